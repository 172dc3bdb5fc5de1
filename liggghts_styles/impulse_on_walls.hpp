#pragma once

#include <cmath>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// What the spheres of this rank have given along x to the walls below and above them, by contacts
/// and by films [N s], since the coupling last sent it to the fluid: its flow does not feel it.
struct ImpulseOnWalls {
  double below = 0, above = 0;

  /// J -= F dt. A wall whose normal lies rather along x or z counts as neither.
  /// @param normal of the wall, towards the sphere
  /// @param force on the sphere along x [N]  @param time [s]
  void take(const double* normal, double force, double time) {
    if (std::abs(normal[1]) < std::fmax(std::abs(normal[0]), std::abs(normal[2]))) return;
    (normal[1] > 0 ? below : above) -= force * time;
  }
};

/// That of the coupling; nullptr without a fluid.
ImpulseOnWalls* find_impulse_on_walls(LAMMPS_NS::LAMMPS* lmp);

}  // namespace bedload
