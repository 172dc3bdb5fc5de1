#pragma once

#include <mpi.h>

namespace bedload {

/// Memory bandwidth that the ranks of `comm` reach together [GB/s], by a = b + s c over arrays of
/// `megabytes` in all, 24 bytes counted per element: median of `repeats`. Collective.
double triad_bandwidth(MPI_Comm comm, int repeats = 5, int megabytes = 576);

}  // namespace bedload
