#pragma once

#include <string>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// Makes `fix couple/fluid` and `coupled_run` known to a LIGGGHTS instance. LIGGGHTS forgets fix
/// styles at `clear`; LAMMPS::post_create, which it then calls, is the place to call this from.
void register_coupling(LAMMPS_NS::LAMMPS* lmp);

/// Name, meaning, syntax and keywords of both (bedload-dem --help-styles).
std::string describe_coupling();

}  // namespace bedload
