#include "fluid/channel/step_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fluid/channel/joint_stability.hpp"
#include "fluid/channel/runge_kutta.hpp"
#include "fluid/grid/diffusion_limit.hpp"
#include "fluid/validation/validate.hpp"

namespace bedload {
namespace {

/// Share of time.step below which a step that follows the flow ends the run: what drives the flow
/// has no bound, and each further step would be shorter. A flow that starts at rest and is held at
/// its velocity shortens its steps some ten times.
constexpr double shortest_share = 0x1p-13;

/// Of the longest step of explicit diffusion: stable with every CFL number that convection allows.
constexpr double always_stable = 0.65;

/// Smallest share that one direction has in the rate of diffusion, 2/h^2 + 1/dy^2.
double least_weight(const Grid& grid) {
  const double along_y = 1 / (grid.thinnest() * grid.thinnest());
  return std::min(1.0, along_y) / (2 + along_y);
}

}  // namespace

StepLimits::StepLimits(const Settings& settings, const Grid& grid)
    : file_(settings.file),
      follows_cfl_(settings.time.cfl != 0.0),
      convection_(settings.fluid.convection),
      longest_(settings.time.step),
      cfl_(settings.time.cfl),
      cell_(grid.h),
      by_diffusion_(std::numeric_limits<double>::infinity()),
      weight_(least_weight(grid)),
      shortest_(follows_cfl_ ? shortest_share * longest_ : 0.0) {
  if (diffusion_is_implicit(settings, grid)) return;
  by_diffusion_ = explicit_diffusion_limit(grid, settings.fluid.kinematic_viscosity);
  shortest_ = std::min(shortest_, shortest_share * by_diffusion_);
  check_explicit_diffusion(settings, grid);
}

double StepLimits::step(double fastest) const {
  if (!follows_cfl_) return longest_;
  constexpr double lengths_per_octave = 16.0;
  const double by_convection = fastest > 0.0 ? cfl_ * cell_ / fastest : longest_;
  const double alone = std::min({longest_, by_diffusion_, by_convection});
  const double wanted = stable_beside_convection(alone, alone * fastest / cell_);
  const double n = std::ceil(lengths_per_octave * std::log2(longest_ / wanted) - 1e-9);
  return longest_ * std::exp2(-n / lengths_per_octave);
}

double StepLimits::stable_beside_convection(double dt, double cfl) const {
  if (!convection_ || dt <= always_stable * by_diffusion_) return dt;
  return std::min(dt, by_diffusion_ * stable_share_of_diffusion(cfl, weight_));
}

bool StepLimits::allows(double cfl, double dt) const {
  if (dt < shortest_ || (convection_ && cfl > imaginary_limit)) return false;
  return follows_cfl_ || stable_beside_convection(dt, cfl) == dt;
}

std::string StepLimits::complaint(std::int64_t step, double time, double dt, double cfl,
                                  const std::array<int, 3>& cell) const {
  if (dt < shortest_)
    return fmt::format(
        "{}: step {} (t = {:.6g}): 'time.cfl' = {} allows steps of {:.3g} only, {:.2g} of "
        "'time.step', so fast is the flow near cell ({}, {}, {}), and the run would never end; "
        "lower what drives it, or, where that speed is meant, 'time.step'.",
        file_, step, time, cfl_, dt, dt / longest_, cell[0], cell[1], cell[2]);
  if (cfl <= imaginary_limit) {
    double shorter = dt;
    while (stable_beside_convection(shorter, cfl * shorter / dt) < shorter) shorter *= 0.99;
    return fmt::format(
        "{}: step {} (t = {:.6g}): convection (CFL number {:.3g} near cell ({}, {}, {})) and "
        "explicit diffusion ({:.0f} % of its longest step) are stable alone, but not together; set "
        "'time.step' to at most {:.4g} (now {}), or 'fluid.diffusion' to \"implicit\".",
        file_, step, time, cfl, cell[0], cell[1], cell[2], 100 * dt / by_diffusion_, shorter, dt);
  }
  return fmt::format(
      "{}: step {} (t = {:.6g}): the CFL number is {:.3g} near cell ({}, {}, {}), but "
      "the scheme is "
      "stable only up to {:.3g}; set 'time.step' to at most {:.4g} (now {}){}.",
      file_, step, time, cfl, cell[0], cell[1], cell[2], imaginary_limit,
      dt * imaginary_limit / cfl, dt,
      follows_cfl_ ? "" : ", or 'time.cfl', with which it follows the flow");
}

}  // namespace bedload
