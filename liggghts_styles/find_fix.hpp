#pragma once

#include <algorithm>
#include <string_view>

#include "fix.h"
#include "modify.h"

namespace bedload {

/// The first fix of the script for which `wanted(fix)` holds, nullptr without one. Unlike LIGGGHTS'
/// own search it may be made by the constructor of a fix whose line stands for an earlier one of
/// the same ID: LIGGGHTS has taken that away by then and left a gap in its list.
template <class Wanted>
LAMMPS_NS::Fix* find_fix_if(const LAMMPS_NS::Modify& modify, Wanted wanted) {
  LAMMPS_NS::Fix** const end = modify.fix + modify.nfix;
  LAMMPS_NS::Fix** const found = std::find_if(
      modify.fix, end, [&](const auto* fix) { return fix != nullptr && wanted(*fix); });
  return found == end ? nullptr : *found;
}

/// That of a style.
inline LAMMPS_NS::Fix* find_fix(const LAMMPS_NS::Modify& modify, std::string_view style) {
  return find_fix_if(modify, [style](const auto& fix) { return fix.style == style; });
}

}  // namespace bedload
