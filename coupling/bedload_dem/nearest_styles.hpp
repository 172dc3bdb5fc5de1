#pragma once

#include <string>
#include <string_view>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// " The nearest fix style is 'couple/fluid'." where LIGGGHTS' sentence is about a word of the
/// present line that it does not know (a command, a style, a contact model); "" about all else.
/// @param error LIGGGHTS' sentence, "ERROR: Invalid fix style: ..."
std::string nearest_style(const LAMMPS_NS::LAMMPS& lmp, std::string_view error);

}  // namespace bedload
