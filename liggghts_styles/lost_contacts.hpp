#pragma once

#include <string_view>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// Ends the run where LIGGGHTS would lose contacts without a word: with `neighbor ... multi`, whose
/// lists hold no pair of spheres, whatever the model.
void refuse_neighbor_multi(LAMMPS_NS::LAMMPS* lmp, std::string_view style);

/// Ends the run where spheres are held together by a fix multisphere: contact models and films of
/// bedload would take each of them for held.
void refuse_clumps(LAMMPS_NS::LAMMPS* lmp, std::string_view style);

}  // namespace bedload
