#pragma once

#include <cstring>

// Lanes are wider than the registers of a processor without AVX, so functions that hand them on
// have another ABI there. None has: all of them, here and where lanes are used, are inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace bedload {

/// Four values side by side, for short loops that the compiler would cut into halves or not
/// vectorise at all.
template <class Real>
using Lanes [[gnu::vector_size(4 * sizeof(Real))]] = Real;
inline constexpr int lane_count = 4;

template <class Real>
[[gnu::always_inline]] inline Lanes<Real> load(const Real* from) {
  Lanes<Real> lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}

template <class Real, class Vector>
[[gnu::always_inline]] inline void store(Real* to, const Vector& lanes) {
  std::memcpy(to, &lanes, sizeof(lanes));
}

template <class Real>
[[gnu::always_inline]] inline Lanes<double> load_double(const Real* from) {
  return __builtin_convertvector(load(from), Lanes<double>);
}

[[gnu::always_inline]] inline double sum_of(const Lanes<double>& v) {
  return (v[0] + v[1]) + (v[2] + v[3]);
}

}  // namespace bedload
