#pragma once

#include <map>
#include <string>

#include "dump.h"
#include "fix_move.h"
#include "input.h"
#include "lammps.h"
#include "modify.h"

/// LIGGGHTS keeps its tables of styles private, and has no other way for a program to add one
/// without editing its sources. An explicit template instantiation may name a private member; that
/// is the legal door used here.
namespace bedload::detail {

template <auto Member>
struct FixMapDoor {
  friend auto& fix_map_of(LAMMPS_NS::Modify& modify) { return modify.*Member; }
};

auto& fix_map_of(LAMMPS_NS::Modify& modify);

template struct FixMapDoor<&LAMMPS_NS::Modify::fix_map>;

/// Whether a dump adds to its file; `dump_modify append` sets it from a script.
template <auto Member>
struct AppendFlagDoor {
  friend auto& append_flag_of(LAMMPS_NS::Dump& dump) { return dump.*Member; }
};

auto& append_flag_of(LAMMPS_NS::Dump& dump);

template struct AppendFlagDoor<&LAMMPS_NS::Dump::append_flag>;

/// Whether a dump has a file of its own for each step.
template <auto Member>
struct FilePerStepDoor {
  friend auto& file_per_step_of(LAMMPS_NS::Dump& dump) { return dump.*Member; }
};

auto& file_per_step_of(LAMMPS_NS::Dump& dump);

template struct FilePerStepDoor<&LAMMPS_NS::Dump::multifile>;

/// Whether a fix move has NULL for some direction, which it then integrates by forces.
template <auto Style, auto... Given>
struct MoveDoor {
  friend bool leaves_component(const LAMMPS_NS::FixMove& move) {
    enum { linear, wiggle, rotate, variable };  // the order of fix_move.cpp
    // For each direction: a velocity, an amplitude, two variables.
    const bool given[] = {static_cast<bool>(move.*Given)...};
    for (int d = 0; d < 3; ++d) {
      const bool* const of = given + 4 * d;
      const int style = move.*Style;
      if ((style == linear && !of[0]) || (style == wiggle && !of[1]) ||
          (style == variable && !of[2] && !of[3]))
        return true;
    }
    return false;
  }
};

bool leaves_component(const LAMMPS_NS::FixMove& move);

using Move = LAMMPS_NS::FixMove;
template struct MoveDoor<&Move::mstyle, &Move::vxflag, &Move::axflag, &Move::xvarstr,
                         &Move::vxvarstr, &Move::vyflag, &Move::ayflag, &Move::yvarstr,
                         &Move::vyvarstr, &Move::vzflag, &Move::azflag, &Move::zvarstr,
                         &Move::vzvarstr>;

template <auto Member>
struct CommandMapDoor {
  friend auto& command_map_of(LAMMPS_NS::Input& input) { return input.*Member; }
};

auto& command_map_of(LAMMPS_NS::Input& input);

template struct CommandMapDoor<&LAMMPS_NS::Input::command_map>;

}  // namespace bedload::detail

namespace bedload {

/// Makes the line `<name> ...` of a script call `command`.
inline void add_command(LAMMPS_NS::LAMMPS* lmp, const std::string& name,
                        void (*command)(LAMMPS_NS::LAMMPS*, int, char**)) {
  (*detail::command_map_of(*lmp->input))[name] = command;
}

/// Makes `fix ID group <name>` create a FixStyle. LIGGGHTS forgets this at `clear`.
template <class FixStyle>
void add_fix_style(LAMMPS_NS::LAMMPS* lmp, const std::string& name) {
  (*detail::fix_map_of(*lmp->modify))[name] = [](LAMMPS_NS::LAMMPS* l, int narg,
                                                 char** arg) -> LAMMPS_NS::Fix* {
    return new FixStyle(l, narg, arg);
  };
}

/// Whether a fix style of this name is there.
inline bool has_fix_style(LAMMPS_NS::LAMMPS* lmp, const std::string& name) {
  return detail::fix_map_of(*lmp->modify)->contains(name);
}

}  // namespace bedload
