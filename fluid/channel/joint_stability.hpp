#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "fluid/settings/scheme_limits.hpp"

namespace bedload {

/// How much of its longest step explicit diffusion keeps beside convection: each has a limit of its
/// own, and both together less. A wave of convection along one direction and the shortest ones of
/// diffusion across it have
///     z = -real_limit s ((1 - w) e + w sin²(θ/2)) + i C sin θ,    |1 + z + z²/2 + z³/6| <= 1
/// for all θ and 0 <= e <= 1; s is the share, 1 up to C = 0.7 on cubes, 0.97, 0.83 and 0.76 at
/// C = 1, 1.5 and √3.
/// @param cfl C = (|u| + |v| + |w|) Δt/h [-], all of it along one direction
/// @param weight w of that direction in 4 ν Δt (2/h² + 1/Δy²) [-], 1/3 on cubes
inline double stable_share_of_diffusion(double cfl, double weight) {
  const auto stable = [&](double share) {
    constexpr int waves = 60, across = 10;
    for (int n = 0; n <= waves; ++n) {
      const double angle = n * std::numbers::pi / waves, sine = std::sin(angle / 2);
      for (int m = 0; m <= across; ++m) {
        const double decay = (1 - weight) * m / across + weight * sine * sine;
        const std::complex<double> z{-real_limit * share * decay, cfl * std::sin(angle)};
        if (std::norm(1.0 + z * (1.0 + z * (0.5 + z / 6.0))) > 1 + 1e-9) return false;
      }
    }
    return true;
  };
  double low = 0, high = 1;
  if (cfl > imaginary_limit) return low;
  if (stable(high)) return high;
  for (int n = 0; n < 20; ++n) (stable(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  return low;
}

}  // namespace bedload
