#pragma once

#include <time.h>

#include <algorithm>
#include <cstdint>

namespace bedload {

/// Nanoseconds of the next sleep of a wait: twice the `last` one, up to 100 us or a thirty-second
/// of what was `slept` so far, whichever is more, and never more than 20 ms.
constexpr std::int64_t next_sleep(std::int64_t last, std::int64_t slept) {
  constexpr std::int64_t short_wait = 100'000;
  constexpr std::int64_t longest = 20'000'000;
  return std::min({2 * last, std::max(short_wait, slept / 32), longest});
}

/// Pauses of somebody who waits for the other program without burning a core: first 200 mere looks
/// (an answer that is already there costs nothing), then sleeps that grow from 2 us on. A busy wait
/// halves the speed of a fluid that shares the core, and sched_yield is a lottery. Each sleep costs
/// some 20 us of a virtual core and stops the fluid there: with sleeps of at most 100 us LIGGGHTS
/// took 13 % of a core and the fluid lost as much again to interrupts. A thirty-second of the wait
/// is not felt: the fluid solves for the pressure meanwhile, which takes longer.
class Backoff {
 public:
  void pause() {
    if (looks_ < most_looks) {
      ++looks_;
      return;
    }
    const timespec sleep{0, nanoseconds_};
    nanosleep(&sleep, nullptr);
    slept_ += nanoseconds_;
    nanoseconds_ = next_sleep(nanoseconds_, slept_);
  }

 private:
  static constexpr int most_looks = 200;
  int looks_ = 0;
  std::int64_t nanoseconds_ = 2'000;
  std::int64_t slept_ = 0;
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
