#pragma once

#include <cstddef>
#include <cstring>
#include <utility>

// Lanes are wider than the registers of a processor without AVX, so functions that hand them on
// have another ABI there. None has: all of them, here and where lanes are used, are inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace bedload {

/// Four values side by side, for short loops that the compiler would cut into halves or not
/// vectorise at all.
template <class Real>
using SimdVector [[gnu::vector_size(4 * sizeof(Real))]] = Real;
inline constexpr int simd_width = 4;

template <class Real>
[[gnu::always_inline]] inline SimdVector<Real> load(const Real* from) {
  SimdVector<Real> lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}

template <class Real, class Vector>
[[gnu::always_inline]] inline void store(Real* to, const Vector& lanes) {
  std::memcpy(to, &lanes, sizeof(lanes));
}

template <class Real>
[[gnu::always_inline]] inline SimdVector<double> load_double(const Real* from) {
  return __builtin_convertvector(load(from), SimdVector<double>);
}

[[gnu::always_inline]] inline double sum_of(const SimdVector<double>& v) {
  return (v[0] + v[1]) + (v[2] + v[3]);
}

/// Each of the four values `times` times, side by side.
template <int times, class Real>
[[gnu::always_inline]] inline auto repeated(const SimdVector<Real>& v) {
  static_assert(times == 1 || times == 2);
  if constexpr (times == 1)
    return v;
  else
    return __builtin_shufflevector(v, v, 0, 0, 1, 1, 2, 2, 3, 3);
}

/// A vector of the same kind as `like` from memory.
template <class Vector, class Real>
[[gnu::always_inline]] inline Vector load_as(const Vector&, const Real* from) {
  Vector values;
  std::memcpy(&values, from, sizeof(values));
  return values;
}

/// As many values as a register holds, for loops over whole rows in which neighbours along the row
/// share what they compute.
#if defined(__AVX512F__)
inline constexpr std::size_t register_bytes = 64;
#elif defined(__AVX__)
inline constexpr std::size_t register_bytes = 32;
#else
inline constexpr std::size_t register_bytes = 16;
#endif
template <class Real>
using WideVector [[gnu::vector_size(register_bytes)]] = Real;
template <class Real>
inline constexpr int wide_width = static_cast<int>(register_bytes / sizeof(Real));

template <class Real>
[[gnu::always_inline]] inline WideVector<Real> load_wide(const Real* from) {
  WideVector<Real> values;
  std::memcpy(&values, from, sizeof(values));
  return values;
}

/// The first `count` values alone.
template <class Real, class Vector>
[[gnu::always_inline]] inline void store_first(int count, Real* to, const Vector& values) {
  for (int n = 0; n < count; ++n) to[n] = values[n];
}

/// The last value of `before`, then all but the last one of `now`.
template <class Vector>
[[gnu::always_inline]] inline Vector moved_up(const Vector& before, const Vector& now) {
  constexpr int width = sizeof(Vector) / sizeof(before[0]);
  return [&]<int... n>(std::integer_sequence<int, n...>) __attribute__((always_inline)) {
    return __builtin_shufflevector(before, now, (width - 1 + n)...);
  }
  (std::make_integer_sequence<int, width>());
}

}  // namespace bedload
