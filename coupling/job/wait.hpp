#pragma once

#include <time.h>

#include <algorithm>
#include <cstdint>

namespace bedload {

/// Pauses of somebody who waits for the other program without burning a core: first 200 mere looks
/// (an answer that is already there costs nothing), then sleeps of 2 us that double up to 100 us.
/// Measured on two cores shared with a busy fluid: 3 % of a core, about 1 ms per exchange, where a
/// busy wait halves the fluid's speed and sched_yield is a lottery.
class Backoff {
 public:
  void pause() {
    if (looks_ < most_looks) {
      ++looks_;
      return;
    }
    const timespec sleep{0, nanoseconds_};
    nanosleep(&sleep, nullptr);
    nanoseconds_ = std::min(2 * nanoseconds_, longest_nanoseconds);
  }

 private:
  static constexpr int most_looks = 200;
  static constexpr std::int64_t longest_nanoseconds = 100'000;
  int looks_ = 0;
  std::int64_t nanoseconds_ = 2'000;
};

/// Returns as soon as `ready()` is true, sleeping in between.
template <class Ready>
void wait_until(Ready ready) {
  Backoff backoff;
  while (!ready()) backoff.pause();
}

/// The same, but gives up after `seconds`. Returns whether it became ready.
template <class Ready>
bool wait_until_or(Ready ready, double seconds) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double end = now() + seconds;
  Backoff backoff;
  while (!ready()) {
    if (now() > end) return false;
    backoff.pause();
  }
  return true;
}

}  // namespace bedload
