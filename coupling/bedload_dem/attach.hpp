#pragma once

#include <mpi.h>

#include "coupling/exchange/dem_side.hpp"

namespace bedload {

/// Ties LIGGGHTS' end of the exchange to the communicator that LIGGGHTS runs on, where fixes and
/// commands, which LIGGGHTS creates itself, find it again. `side` has to outlive the use.
void attach(MPI_Comm world, DemSide* side);

/// The exchange tied to `world`; nullptr: this job has no fluid.
DemSide* attached(MPI_Comm world);

}  // namespace bedload
