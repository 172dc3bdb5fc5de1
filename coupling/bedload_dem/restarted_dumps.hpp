#pragma once

#include <cstdint>

namespace LAMMPS_NS {
class Output;
}

namespace bedload {

/// Dumps with one file for all steps add to what it holds. To be called before LIGGGHTS
/// initialises them, which opens that file. Files of one step each are written anew.
void append_to_dumps(LAMMPS_NS::Output& output);

/// Dumps leave out `step`, which is in their files already.
void leave_out_step(LAMMPS_NS::Output& output, std::int64_t step);

}  // namespace bedload
