#include "liggghts_styles/lost_contacts.hpp"

#include <fmt/format.h>

#include "fix.h"
#include "lammps.h"
#include "liggghts_styles/find_fix.hpp"
#include "liggghts_styles/keywords.hpp"
#include "neighbor.h"
#include "update.h"

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
    const std::string_view made_by = fix.style;
    return made_by.starts_with("multisphere") || made_by.starts_with("rigid");
  });
  if (clumps != nullptr)
    stop_run(lmp, fmt::format("{}: fix {} (id {}) makes clumps, and bedload has spheres only: each "
                              "would be loaded and moved by itself",
                              style, clumps->style, clumps->id));
}

bool one_step_late(LAMMPS_NS::LAMMPS* lmp, double step) {
  const LAMMPS_NS::Update& update = *lmp->update;
  return step > 0 && update.ntimestep == update.firststep &&
         step == static_cast<double>(update.ntimestep - 1);
}

}  // namespace bedload
