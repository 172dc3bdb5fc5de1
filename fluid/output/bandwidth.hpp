#pragma once

#include <mpi.h>

#include "fluid/grid/field.hpp"

namespace bedload {

/// The arrays of the triad a = b + s c, on the kind of pages that fields have.
class Triad {
 public:
  /// `megabytes` over all ranks of `comm`.
  explicit Triad(MPI_Comm comm, int megabytes = 576);
  /// Bandwidth of one pass of all ranks [GB/s], 24 bytes counted per element. Collective.
  double pass();

 private:
  MPI_Comm comm_;
  int ranks_ = 1;
  double scale_ = 3.0;
  AlignedArray<double> a_, b_, c_;
};

/// Memory bandwidth that the ranks of `comm` reach together [GB/s], by a = b + s c over arrays of
/// `megabytes` in all, 24 bytes counted per element: median of `repeats`. Collective.
double triad_bandwidth(MPI_Comm comm, int repeats = 5, int megabytes = 576);

}  // namespace bedload
