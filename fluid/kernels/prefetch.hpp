#pragma once

#include <cstddef>

namespace bedload {

/// Asks for the cache lines of `count` values, to be read or to be written. Where a loop goes from
/// row to row the processor's own guesses end with each page; values that are asked for while the
/// row before is computed are there when their turn comes.
template <class Real>
[[gnu::always_inline]] inline void ask_for(const Real* values, std::size_t count) {
  for (std::size_t n = 0; n < count; n += 64 / sizeof(Real)) __builtin_prefetch(values + n, 0);
}
template <class Real>
[[gnu::always_inline]] inline void ask_to_write(Real* values, std::size_t count) {
  for (std::size_t n = 0; n < count; n += 64 / sizeof(Real)) __builtin_prefetch(values + n, 1);
}

}  // namespace bedload
