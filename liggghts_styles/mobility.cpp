#include "liggghts_styles/mobility.hpp"

#include <fmt/format.h>

#include <string_view>

#include "fix.h"
#include "fix_move.h"
#include "lammps.h"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/private_access.hpp"
#include "modify.h"

namespace bedload {

Mobility::Mobility(LAMMPS_NS::LAMMPS* lmp) {
  const LAMMPS_NS::Modify& modify = *lmp->modify;
  for (int n = 0; n < modify.nfix; ++n) {
    const LAMMPS_NS::Fix& fix = *modify.fix[n];
    const std::string_view style(fix.style);
    if (style == "move" && detail::leaves_component(static_cast<const LAMMPS_NS::FixMove&>(fix)))
      stop_run(lmp, fmt::format("fix move (id {}): NULL lets its spheres go by forces in one "
                                "direction and as prescribed in another, but to collisions and "
                                "films a sphere is free or held; give each direction a value",
                                fix.id));
    if (style == "freeze" || style == "move" || style == "nve/noforce") {
      held_ |= fix.groupbit;
    } else if (fix.time_integrate != 0) {
      integrated_ |= fix.groupbit;
    }
  }
}

}  // namespace bedload
