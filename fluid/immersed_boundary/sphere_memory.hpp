#pragma once

#include <array>

#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/interior.hpp"

namespace bedload {

/// What is kept of a mobile sphere between stages, per fluid density, by the rank that holds its
/// centre: it goes along when the centre changes rank, and into checkpoints.
struct SphereMemory {
  InteriorMomentum forced;                       ///< inside after the last forcing
  InteriorMomentum deferred_impulse;             ///< of changes inside between two forcings
  Vec3 deferred_angular_impulse = Vec3::Zero();  ///< of all kinds [L^5/T]
  Vec3 deferred_reaction = Vec3::Zero();         ///< where spheres move once per step [L^4/T]
  Vec3 excess_spin = Vec3::Zero();               ///< of the markers, excess_spin.hpp [1/T]
  bool fresh = true;                             ///< nothing is known of it yet

  /// Datasets of the vectors, in their order.
  static constexpr std::array vector_names{"interior_impulse",
                                           "interior_angular_impulse",
                                           "deferred_impulse",
                                           "deferred_interior_angular_impulse",
                                           "deferred_angular_impulse",
                                           "deferred_reaction",
                                           "excess_spin"};
  std::array<Vec3*, vector_names.size()> vectors() {
    return {&forced.linear,
            &forced.angular,
            &deferred_impulse.linear,
            &deferred_impulse.angular,
            &deferred_angular_impulse,
            &deferred_reaction,
            &excess_spin};
  }
};

}  // namespace bedload
