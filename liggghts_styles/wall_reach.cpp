#include "liggghts_styles/wall_reach.hpp"

#include <fmt/format.h>

#include <string_view>

#include "fix_wall_gran.h"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/liggghts.hpp"

namespace bedload {

void reach_out(LAMMPS_NS::LAMMPS* lmp, std::string_view style, double range) {
  const double smallest = lmp->force->registry.min_radius();
  if (!(smallest > 0)) return;  // no spheres yet
  lmp->neighbor->register_contact_dist_factor(1 + range / smallest);
  for (int n = 0; n < lmp->modify->nfix; ++n) {
    const LAMMPS_NS::Fix* fix = lmp->modify->fix[n];
    if (std::string_view(fix->style) != "wall/gran") continue;
    const auto* wall = static_cast<const LAMMPS_NS::FixWallGran*>(fix);
    if (!wall->is_mesh_wall() && lmp->neighbor->skin < 2 * range) {
      stop_run(lmp, fmt::format("{}: the neighbour skin of {} is too small for the range {} at the "
                                "primitive wall '{}', write 'neighbor {} bin' or more",
                                style, lmp->neighbor->skin, range, fix->id, 2 * range));
    }
  }
}

}  // namespace bedload
