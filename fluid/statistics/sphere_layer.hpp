#pragma once

#include <algorithm>
#include <numbers>

namespace bedload {

/// What of a sphere lies between two horizontal planes.
struct SphereLayer {
  double volume = 0.0;  ///< [L^3]
  double moment = 0.0;  ///< integral of the height over the centre over that volume [L^4]
};

/// The part of a sphere between the heights `below` and `above` over its centre [L], exactly:
///
///   V = int pi (R^2 - s^2) ds = pi (R^2 s - s^3/3),    M = int s pi (R^2 - s^2) ds
///                                                        = pi (R^2 s^2/2 - s^4/4).
inline SphereLayer sphere_layer(double radius, double below, double above) {
  // A lower cap is smaller than the round-off of the integrals, which may have either sign.
  const double end = (1.0 - 1e-9) * radius;
  if (above <= -end || below >= end) return {};
  const double r2 = radius * radius;
  const auto up_to = [&](double height) {
    const double s = std::clamp(height, -radius, radius), s2 = s * s;
    return SphereLayer{std::numbers::pi * s * (r2 - s2 / 3.0),
                       std::numbers::pi * s2 * (r2 / 2.0 - s2 / 4.0)};
  };
  const SphereLayer lower = up_to(below), upper = up_to(above);
  return {upper.volume - lower.volume, upper.moment - lower.moment};
}

}  // namespace bedload
