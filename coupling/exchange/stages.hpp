#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace bedload {

/// LIGGGHTS' steps behind the loads of each Runge-Kutta stage 8/15, 2/15, 1/3 of the fluid's step,
/// all of one length. A stage without steps sends no loads: they wait for the next one that has
/// some.
///
/// In each stage: 8, 2, 5 steps of dt/15 (Biegert, Vowinckel, Meiburg 2017) or whole multiples:
/// with one step per fluid step the rebound from a wall depends on where between two steps the
/// collision falls, with these it does not. Once per step: any number, behind the last stage.
struct DemSteps {
  std::array<std::int32_t, 3> in_stage{8, 2, 5};

  /// As coupling.exchange and coupling.dem_steps say, the latter a multiple of 15 if in each stage.
  static constexpr DemSteps of(bool in_each_stage, int per_step) {
    if (!in_each_stage) return {{0, 0, per_step}};
    return {{8 * per_step / 15, 2 * per_step / 15, 5 * per_step / 15}};
  }

  constexpr int per_step() const { return in_stage[0] + in_stage[1] + in_stage[2]; }
  constexpr bool exchange_in(int stage) const {
    return in_stage[static_cast<std::size_t>(stage)] > 0;
  }
  /// LIGGGHTS' time step [T] for a fluid time step [T].
  constexpr double time_step(double fluid_time_step) const { return fluid_time_step / per_step(); }
  /// Time [T] that the loads of a stage act.
  constexpr double duration(int stage, double fluid_time_step) const {
    return in_stage[static_cast<std::size_t>(stage)] * time_step(fluid_time_step);
  }
};

/// Of a step, with a trace for rounding.
inline constexpr double longest_stage_of_step = 8.0 / 15.0 * (1.0 + 1e-12);

}  // namespace bedload
