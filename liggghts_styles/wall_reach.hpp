#pragma once

#include <string_view>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// Makes LIGGGHTS call the contact models for surfaces up to `range` [m] apart: raises the contact
/// distance factor to 1 + range / r_min, and ends the run with one sentence if there is a primitive
/// wall and the neighbour skin is below 2 range (such a wall looks for spheres within the skin, and
/// a sphere may move by half of it before the lists are renewed). To be called on every rank,
/// before pair cut-offs are set, thus from a contact model's connectToProperties.
void reach_out(LAMMPS_NS::LAMMPS* lmp, std::string_view style, double range);

}  // namespace bedload
