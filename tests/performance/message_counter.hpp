#pragma once

#include <cstdint>

namespace bedload {

/// What this rank has sent to other ranks since the program began, and sums over ranks that it took
/// part in. The counter stands between program and MPI library (MPI's profiling interface), so that
/// the solver need not count.
struct Traffic {
  std::int64_t messages = 0, bytes = 0, sums = 0;
  std::int64_t gathered = 0;  ///< bytes that gathers put together on this rank
};
const Traffic& traffic();

/// Called after each message, where a program defines it.
void after_message() __attribute__((weak));

}  // namespace bedload
