#pragma once

#include <array>
#include <vector>

#include "coupling/bedload_dem/coupled_spheres.hpp"
#include "coupling/exchange/message.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// Part of an overlap by which a sphere itself has moved into the other: as the reduced mass has
/// it, all of it against what does not move.
/// @param own, other 1/mass, 0 of what does not move [1/M]
inline double share_of_overlap(double own, double other) { return own / (own + other); }

/// How far the centre of each of this rank's mobile spheres has moved into the spheres and walls of
/// the fluid that it overlaps [L], with the unit vector n that points from a sphere's centre into
/// the other:
///
///   o_i = sum over contacts of (1/m_i) / (1/m_i + 1/m_j) (r_i + r_j - |x_j - x_i|) n
///
/// Zero for the others, and for mobile spheres that are held or that a fix moves as prescribed:
/// they are where the script wants them, and have no 1/m. Positions of ghosts and the list of pairs
/// are those of the last step.
/// @param walls walls[d]: whether the box ends at walls along d
std::vector<Triple> overlaps_of(LAMMPS_NS::LAMMPS* lmp, const CoupledSpheres& spheres,
                                const Triple& length, const std::array<bool, 3>& walls);

}  // namespace bedload
