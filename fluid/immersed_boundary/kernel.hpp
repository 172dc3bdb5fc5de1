#pragma once

#include <array>
#include <cmath>

namespace bedload {

/// The regularised delta function of Roma, Peskin and Berger, J. Comput. Phys. 153 (1999), eq. 22,
/// of a distance r in cells:
///
///   phi(r) = (1 + sqrt(1 - 3 r^2)) / 3                        |r| <= 1/2
///   phi(r) = (5 - 3|r| - sqrt(1 - 3 (1 - |r|)^2)) / 6   1/2 <= |r| <= 3/2
///   phi(r) = 0                                          3/2 <= |r|
inline double roma_kernel(double r) {
  const double a = std::abs(r);
  if (a <= 0.5) return (1.0 + std::sqrt(1.0 - 3.0 * a * a)) / 3.0;
  if (a >= 1.5) return 0.0;
  return (5.0 - 3.0 * a - std::sqrt(1.0 - 3.0 * (1.0 - a) * (1.0 - a))) / 6.0;
}

/// phi(d) for |d| <= 1/2.
template <class Real>
Real roma_middle_weight(Real d) {
  return (Real{1} + std::sqrt(Real{1} - Real{3} * d * d)) * (Real{1} / Real{3});
}

/// The kernel's weights at the points -1, 0, +1 seen from a marker at `d`, |d| <= 1/2, off the
/// middle point. The outer two follow from the middle one by the kernel's moments, sum phi = 1 and
/// sum r phi = 0, which therefore hold to round-off.
inline std::array<double, 3> roma_weights(double d) {
  const double middle = roma_middle_weight(d);
  return {0.5 * (1.0 - middle - d), middle, 0.5 * (1.0 - middle + d)};
}

}  // namespace bedload
