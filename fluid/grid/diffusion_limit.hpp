#pragma once

#include "fluid/grid/grid.hpp"
#include "fluid/settings/scheme_limits.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// Longest step that explicit diffusion is stable with [T]: the largest eigenvalue of nu times the
/// second differences, 4 nu (2/h^2 + 1/dy^2), meets the real limit of the scheme.
inline double explicit_diffusion_limit(const Grid& grid, double viscosity) {
  const double thinnest = grid.thinnest();
  return real_limit * grid.h * grid.h / (4.0 * viscosity * (2.0 + 1.0 / (thinnest * thinnest)));
}

/// Whether diffusion is implicit: as the user says, otherwise where time.step is longer than
/// explicit diffusion allows. Where time.cfl chooses the step, time.step is only its upper bound,
/// and an implicit step costs as much as 2.5 explicit ones.
inline bool diffusion_is_implicit(const Settings& settings, const Grid& grid) {
  if (settings.fluid.diffusion != Diffusion::automatic)
    return settings.fluid.diffusion == Diffusion::implicit;
  const double worth = settings.time.cfl > 0.0 ? 2.5 : 1.0;
  return settings.time.step >
         worth * explicit_diffusion_limit(grid, settings.fluid.kinematic_viscosity);
}

}  // namespace bedload
