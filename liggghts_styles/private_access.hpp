#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>

#include "dump.h"
#include "fix_insert.h"
#include "fix_move.h"
#include "input.h"
#include "lammps.h"
#include "liggghts_styles/private_member.hpp"
#include "modify.h"

/// What LIGGGHTS keeps private: its tables of styles and commands, and how dumps, moves and
/// insertions are set.
namespace bedload::detail {

struct FixStyles {
  friend constexpr auto member(FixStyles);
};
template struct PrivateMember<FixStyles, &LAMMPS_NS::Modify::fix_map>;

struct Commands {
  friend constexpr auto member(Commands);
};
template struct PrivateMember<Commands, &LAMMPS_NS::Input::command_map>;

/// Whether a dump adds to its file; `dump_modify append` sets it from a script.
struct DumpAppends {
  friend constexpr auto member(DumpAppends);
};
template struct PrivateMember<DumpAppends, &LAMMPS_NS::Dump::append_flag>;

/// Whether a dump has a file of its own for each step.
struct DumpPerStep {
  friend constexpr auto member(DumpPerStep);
};
template struct PrivateMember<DumpPerStep, &LAMMPS_NS::Dump::multifile>;

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

/// What fixes insert protect.
class Insertion : public LAMMPS_NS::FixInsert {
 public:
  /// Whether one had put in all its spheres. LIGGGHTS gives it the script's first step again, in
  /// case it is to go on with more, and then refuses that step as past.
  /// @param state written by FixInsert: seed, spheres so far, first step, next step (0: none), mass
  static bool is_over(const LAMMPS_NS::FixInsert& fix, std::span<const std::uint8_t> state) {
    double next = 0.0;
    std::memcpy(&next, state.data() + 3 * sizeof(double), sizeof(double));
    const bool wants_more = fix.*(&Insertion::ninsert_exists) != 0 &&
                            fix.*(&Insertion::ninsert) > fix.*(&Insertion::ninserted);
    return next == 0.0 && !wants_more;
  }

  /// Spheres that it has put in so far, on all ranks.
  static int so_far(const LAMMPS_NS::FixInsert& fix) { return fix.*(&Insertion::ninserted); }

  /// Whether it gives all spheres other numbers (compress_tags yes).
  static bool compresses(const LAMMPS_NS::FixInsert& fix) {
    return fix.*(&Insertion::compress_flag);
  }
};

}  // namespace bedload::detail

namespace bedload {

/// Makes the line `<name> ...` of a script call `command`.
inline void add_command(LAMMPS_NS::LAMMPS* lmp, const std::string& name,
                        void (*command)(LAMMPS_NS::LAMMPS*, int, char**)) {
  (*(lmp->input->*member(detail::Commands{})))[name] = command;
}

/// Makes `fix ID group <name>` create a FixStyle. LIGGGHTS forgets this at `clear`.
template <class FixStyle>
void add_fix_style(LAMMPS_NS::LAMMPS* lmp, const std::string& name) {
  (*(lmp->modify->*member(detail::FixStyles{})))[name] = [](LAMMPS_NS::LAMMPS* l, int narg,
                                                            char** arg) -> LAMMPS_NS::Fix* {
    return new FixStyle(l, narg, arg);
  };
}

/// Whether a fix style of this name is there.
inline bool has_fix_style(LAMMPS_NS::LAMMPS* lmp, const std::string& name) {
  return (lmp->modify->*member(detail::FixStyles{}))->contains(name);
}

}  // namespace bedload
