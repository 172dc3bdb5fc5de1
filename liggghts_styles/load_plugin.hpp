#pragma once

#include "liggghts_styles/keywords.hpp"

namespace bedload {

inline constexpr WordKeyword plugin_words[] = {
    {"load", "none, required", "File of the plug-in, as seen from the folder of the run."}};
inline constexpr StyleHelp plugin_help{
    "plugin",
    "Adds the contact models of a plug-in, for the lines of the script behind it.",
    "plugin load FILE",
    {},
    plugin_words};

/// The command `plugin load FILE`. Loading the same file again changes nothing.
void load_plugin(LAMMPS_NS::LAMMPS* lmp, int narg, char** arg);

}  // namespace bedload
