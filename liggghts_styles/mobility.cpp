#include "liggghts_styles/mobility.hpp"

#include <string_view>

#include "fix.h"
#include "lammps.h"
#include "modify.h"

namespace bedload {

Mobility::Mobility(LAMMPS_NS::LAMMPS* lmp) {
  const LAMMPS_NS::Modify& modify = *lmp->modify;
  for (int n = 0; n < modify.nfix; ++n) {
    const LAMMPS_NS::Fix& fix = *modify.fix[n];
    const std::string_view style(fix.style);
    if (style == "freeze" || style == "move" || style == "nve/noforce") {
      held_ |= fix.groupbit;
    } else if (fix.time_integrate != 0) {
      integrated_ |= fix.groupbit;
    }
  }
}

}  // namespace bedload
