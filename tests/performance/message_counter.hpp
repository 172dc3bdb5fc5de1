#pragma once

#include <cstdint>

namespace bedload {

/// Bytes that this rank has sent to other ranks since the program began. The counter stands between
/// program and MPI library (MPI's profiling interface), so that the solver need not count.
std::int64_t bytes_sent();

}  // namespace bedload
