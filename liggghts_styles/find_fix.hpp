#pragma once

#include <algorithm>
#include <string_view>

#include "fix.h"
#include "modify.h"

namespace bedload {

/// The first fix of `style` in the script, nullptr without one. Unlike LIGGGHTS' own search it may
/// be asked by the constructor of a fix whose line stands for an earlier one of the same ID:
/// LIGGGHTS has taken that away by then and left a gap in its list.
inline LAMMPS_NS::Fix* find_fix(const LAMMPS_NS::Modify& modify, std::string_view style) {
  LAMMPS_NS::Fix** const end = modify.fix + modify.nfix;
  LAMMPS_NS::Fix** const found = std::find_if(modify.fix, end, [style](const auto* fix) {
    return fix != nullptr && std::string_view(fix->style) == style;
  });
  return found == end ? nullptr : *found;
}

}  // namespace bedload
