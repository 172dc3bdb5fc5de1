#pragma once

#include <vector>

#include "liggghts_styles/keywords.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// Makes `fix couple/fluid` and `coupled_run` known to a LIGGGHTS instance. LIGGGHTS forgets fix
/// styles at `clear`; LAMMPS::post_create, which it then calls, is the place to call this from.
void register_coupling(LAMMPS_NS::LAMMPS* lmp);

/// What the help says of both (bedload-dem --help-styles).
std::vector<StyleHelp> coupling_styles();

}  // namespace bedload
