#pragma once

#include <vector>

#include "liggghts_styles/keywords.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// Adds our contact models, fix lubrication, fix collision/table and the command plugin to a
/// LIGGGHTS object.
///
/// Call it from LAMMPS_NS::LAMMPS::post_create, which the main program defines:
///
///     __attribute__((visibility("default"))) void LAMMPS_NS::LAMMPS::post_create() {
///       bedload::register_styles(this);
///     }
///
/// LIGGGHTS calls that function at construction and at every `clear`, which forgets fix styles; the
/// definition in the executable takes the place of the empty one in the library.
void register_styles(LAMMPS_NS::LAMMPS* lmp);

/// What the help says of each of them (bedload-dem --help-styles).
std::vector<StyleHelp> styles();

/// Ends the run with one sentence if register_styles was never called for this object, for instance
/// because post_create of the library was called instead of the program's.
void check_styles(LAMMPS_NS::LAMMPS* lmp);

}  // namespace bedload
