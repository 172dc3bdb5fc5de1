#pragma once

#include <array>
#include <cmath>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// What the spheres of this rank have given to the walls below and above them, by contacts and by
/// films [N s], since the coupling last sent it to the fluid: its flow does not feel it.
struct ImpulseOnWalls {
  std::array<double, 3> below{}, above{};

  /// J -= F dt, F on the sphere. A wall whose normal lies rather along x or z counts as neither.
  /// @param normal of the wall, towards the sphere
  /// @param force on the sphere [N]  @param time [s]
  void take(const double* normal, const double* force, double time) {
    if (std::abs(normal[1]) < std::fmax(std::abs(normal[0]), std::abs(normal[2]))) return;
    std::array<double, 3>& wall = normal[1] > 0 ? below : above;
    for (std::size_t d = 0; d < wall.size(); ++d) wall[d] -= force[d] * time;
  }
};

/// That of the coupling; nullptr without a fluid.
ImpulseOnWalls* find_impulse_on_walls(LAMMPS_NS::LAMMPS* lmp);

}  // namespace bedload
