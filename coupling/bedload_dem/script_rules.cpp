#include "coupling/bedload_dem/script_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "comm.h"
#include "coupling/bedload_dem/script_gravity.hpp"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "lammps.h"
#include "liggghts_styles/keywords.hpp"
#include "modify.h"

namespace bedload {
namespace {

/// The first fix whose style begins like this; nullptr: there is none.
const LAMMPS_NS::Fix* find_fix(const LAMMPS_NS::Modify& modify, std::string_view style) {
  const auto* const end = modify.fix + modify.nfix;
  const auto* const found = std::find_if(
      modify.fix, modify.fix + modify.nfix,
      [&](const auto* fix) { return std::string_view(fix->style).starts_with(style); });
  return found == end ? nullptr : *found;
}

}  // namespace

int inserting_fixes(LAMMPS_NS::LAMMPS* lmp) {
  const LAMMPS_NS::Modify& modify = *lmp->modify;
  return static_cast<int>(std::count_if(modify.fix, modify.fix + modify.nfix, [](const auto* fix) {
    return std::string_view(fix->style).starts_with("insert/");
  }));
}

void refuse_clumps(LAMMPS_NS::LAMMPS* lmp) {
  if (const auto* const clumps = find_fix(*lmp->modify, "multisphere"))
    stop_run(lmp,
             fmt::format("fix couple/fluid: fix {} (id {}) makes clumps, and bedload has spheres "
                         "only: each would be loaded and moved by itself",
                         clumps->style, clumps->id));
}

void warn_without_walls(LAMMPS_NS::LAMMPS* lmp, bool fixed_spheres) {
  if (fixed_spheres || find_fix(*lmp->modify, "wall/") != nullptr) return;
  const Triple gravity = script_gravity(lmp, [](int) { return false; }).value;
  for (std::size_t d = 0; d < 3; ++d)
    if (gravity[d] != 0.0 && lmp->domain->periodicity[d] == 0 && lmp->comm->me == 0)
      lmp->error->warning(
          FLERR,
          fmt::format("fix couple/fluid: gravity points along {0}, but the script has no wall "
                      "there and no fixed sphere, and spheres go on through the fluid's; write "
                      "'fix ID all wall/gran ... primitive type 1 {0}plane {1} ...'",
                      "xyz"[d], gravity[d] < 0.0 ? lmp->domain->boxlo[d] : lmp->domain->boxhi[d])
              .c_str());
}

}  // namespace bedload
