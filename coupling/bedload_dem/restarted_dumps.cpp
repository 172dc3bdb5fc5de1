#include "coupling/bedload_dem/restarted_dumps.hpp"

#include "dump.h"
#include "liggghts_styles/private_access.hpp"
#include "output.h"

namespace bedload {

void append_to_dumps(LAMMPS_NS::Output& output) {
  for (int n = 0; n < output.ndump; ++n) {
    LAMMPS_NS::Dump& dump = *output.dump[n];
    if (dump.*member(detail::DumpPerStep{}) == 0) dump.*member(detail::DumpAppends{}) = 1;
  }
}

void leave_out_step(LAMMPS_NS::Output& output, std::int64_t step) {
  for (int n = 0; n < output.ndump; ++n) output.last_dump[n] = step;
}

}  // namespace bedload
