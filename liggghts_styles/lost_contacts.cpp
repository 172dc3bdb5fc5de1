#include "liggghts_styles/lost_contacts.hpp"

#include <fmt/format.h>

#include "fix.h"
#include "lammps.h"
#include "liggghts_styles/find_fix.hpp"
#include "liggghts_styles/keywords.hpp"
#include "neighbor.h"

namespace bedload {

void refuse_neighbor_multi(LAMMPS_NS::LAMMPS* lmp, std::string_view style) {
  constexpr int multi = 2;  // of Neighbor::style
  if (lmp->neighbor->style == multi)
    stop_run(lmp, fmt::format("{}: 'neighbor ... multi' finds no contacts of spheres; write "
                              "'neighbor {:g} bin'",
                              style, lmp->neighbor->skin));
}

void refuse_clumps(LAMMPS_NS::LAMMPS* lmp, std::string_view style) {
  const auto* const clumps = find_fix_if(*lmp->modify, [](const auto& fix) {
    return std::string_view(fix.style).starts_with("multisphere");
  });
  if (clumps != nullptr)
    stop_run(lmp, fmt::format("{}: fix {} (id {}) makes clumps, and bedload has spheres only: each "
                              "would be loaded and moved by itself",
                              style, clumps->style, clumps->id));
}

}  // namespace bedload
