#pragma once

#include <string_view>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// Ends the run where LIGGGHTS would lose contacts without a word: with `neighbor ... multi`, whose
/// lists hold no pair of spheres, whatever the model.
void refuse_neighbor_multi(LAMMPS_NS::LAMMPS* lmp, std::string_view style);

/// Ends the run where spheres are held together by a fix multisphere or rigid: contact models and
/// films of bedload would take each of them for held, or for free.
void refuse_clumps(LAMMPS_NS::LAMMPS* lmp, std::string_view style);

/// Whether a contact between spheres whose memory is of the step `step` comes from a file that the
/// command `restart N` wrote, and its forces are asked for for the first time since. Such a file
/// has spheres of its own step and contacts of the step before (LIGGGHTS writes contacts down when
/// it makes neighbour lists, before the forces); those of walls are of its own step.
bool one_step_late(LAMMPS_NS::LAMMPS* lmp, double step);

}  // namespace bedload
