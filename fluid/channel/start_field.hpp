#pragma once

#include <array>
#include <cstddef>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// Mean streamwise velocity at height y of the profile that a run starts from (start.from): zero
/// below start.height; above it, over the depth that remains, of mean start.velocity:
///   laminar:      the parabola (or straight line, for moving walls) that the y walls ask for, and
///                 the straight line along z where they move along it, too; where no y end is a
///                 wall, that of moving z walls is added;
///   logarithmic:  Reichardt's law of the wall, u+ = ln(1 + 0.4 y+)/0.4
///                 + 7.8 (1 - exp(-y+/11) - (y+/11) exp(-y+/3))  (ZAMM 31 (1951) 208),
///                 y+ from the nearer no-slip wall, the friction velocity found from the mean.
class StartProfile {
 public:
  StartProfile(const Settings& settings, const Grid& grid);
  double operator()(double y) const;
  /// Of the laminar flow that moving y walls drive along z [L/T].
  double across(double y) const;
  /// Of the laminar flow that moving z walls drive along x, where no y end is a wall, and along y,
  /// where y is periodic [L/T].
  std::array<double, 2> between_z_walls(double z) const;

 private:
  double shape(double s) const;
  double law_of_the_wall(double s) const;
  double mean() const;

  /// The straight line between two ends, of which those that are no walls hold nothing.
  struct Couette {
    bool lower = false, upper = false;
    std::array<double, 3> lower_velocity{}, upper_velocity{};

    Couette() = default;
    Couette(const Grid& grid, std::size_t direction);
    double at(double share, std::size_t component) const;
  };

  Start kind_;
  Couette y_walls_, z_walls_;
  double width_;
  bool y_is_periodic_;
  double bottom_, depth_, velocity_, viscosity_;
  double friction_velocity_ = 0.0;
};

/// Writes profile and disturbances into the own planes of `velocity` (ghosts are left alone; the
/// divergence is second-order small and left to a projection).
///
/// Disturbances, of amplitude start.disturbance * start.velocity: pairs of streamwise rolls about
/// as wide as the flow is deep, which lift slow fluid into streaks, and random Fourier modes
/// (start.seed) on which the streaks break up. All of them are functions of position alone, hence
/// the same for any number of ranks.
template <class Real>
void write_start_field(Field<Real>& velocity, const Settings& settings, const Grid& grid,
                       const Decomposition& decomposition);

}  // namespace bedload
