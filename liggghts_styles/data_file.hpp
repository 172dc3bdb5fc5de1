#pragma once

#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace LAMMPS_NS {
class LAMMPS;
}

/// Data files of LIGGGHTS (`read_data`). LIGGGHTS reads a word that is no number as 0 and puts a
/// coordinate that is NaN at the begin of a periodic box, both without a sentence.
namespace bedload {

/// Columns of the sections Atoms and Velocities for `atom_style granular`.
inline constexpr std::string_view granular_atoms[] = {"number", "type", "diameter", "density",
                                                      "x",      "y",    "z"};
inline constexpr std::string_view granular_velocities[] = {"number",  "vx",      "vy",     "vz",
                                                           "omega_x", "omega_y", "omega_z"};

/// The first row of these two sections that does not consist of finite numbers, or not of as many
/// as the first row of its section: "line 12: the x is 'nan', ...". Nothing: all is well, or so
/// broken that LIGGGHTS says it.
/// @param names_known whether the columns are those of `atom_style granular`
std::optional<std::string> flaw_of_data(std::FILE* file, bool names_known);

/// The command `read_data` with that check in front.
void read_checked_data(LAMMPS_NS::LAMMPS* lmp, int narg, char** arg);

}  // namespace bedload
