#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "fluid/grid/grid.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// The longest step that the scheme is stable with, and the step that is chosen within it.
class StepLimits {
 public:
  /// Throws UserError for a time.step that explicit diffusion is not stable with.
  StepLimits(const Settings& settings, const Grid& grid);

  /// With time.cfl, the longest of the steps time.step 2^(-n/16), n = 0, 1, .., that keeps to it,
  /// where `fastest` is the largest |u|+|v|+|w| [L/T], and to the limit of explicit diffusion
  /// beside it [T]. Few lengths, so that what depends on the step is seldom made anew; and a
  /// function of the present field alone, so that a run that is continued takes the same. Otherwise
  /// time.step.
  double step(double fastest) const;

  /// Whether convection is stable at this CFL number, in a step of given length explicit diffusion
  /// beside it, too, and the step not so short that the run would never end.
  bool allows(double cfl, double dt) const;

  /// One sentence for a step (its number, time and length) that is too long, or too short, in
  /// `cell`.
  std::string complaint(std::int64_t step, double time, double dt, double cfl,
                        const std::array<int, 3>& cell) const;

 private:
  /// dt, or the longest step of explicit diffusion beside convection at this CFL number where that
  /// is shorter [T].
  double stable_beside_convection(double dt, double cfl) const;

  std::string file_;
  bool follows_cfl_, convection_;
  double longest_, cfl_, cell_, by_diffusion_, weight_, shortest_;
};

}  // namespace bedload
