#pragma once

#include <array>

namespace bedload {

/// LIGGGHTS' steps in the three Runge-Kutta stages 8/15, 2/15, 1/3 of the fluid's step, each of
/// length dt/15 (Biegert, Vowinckel, Meiburg 2017): with one step per fluid step the rebound from a
/// wall depends on where between two steps the collision falls, with these it does not.
inline constexpr std::array<int, 3> dem_substeps{8, 2, 5};
inline constexpr int dem_substeps_per_step = dem_substeps[0] + dem_substeps[1] + dem_substeps[2];

/// LIGGGHTS' time step [T] for a fluid time step [T].
constexpr double dem_time_step(double fluid_time_step) {
  return fluid_time_step / dem_substeps_per_step;
}

/// Length [T] of a Runge-Kutta stage.
constexpr double stage_length(int stage, double fluid_time_step) {
  return dem_substeps[static_cast<std::size_t>(stage)] * dem_time_step(fluid_time_step);
}

}  // namespace bedload
