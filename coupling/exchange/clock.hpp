#pragma once

#include <chrono>

namespace bedload {

/// Seconds on the clock that all processes of a machine share, for the common time line of the two
/// programs.
inline double clock_seconds() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace bedload
