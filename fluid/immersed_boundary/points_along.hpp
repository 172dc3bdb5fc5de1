#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/stencil.hpp"

namespace bedload {

/// Points of one component along one direction, seen from a sphere.
struct PointsAlong {
  StencilAxis axis;
  double centre;  ///< [L]
  double per_cell = 1.0 / axis.h;
  double place(int n) const { return axis.origin + n * axis.h - centre; }
  /// First and last point within `width` of the centre; beyond an end where periodic, but none
  /// twice: those that are nearer to an image of the centre belong to that.
  std::array<int, 2> within(double width) const { return between(-width, width); }
  /// The same of the points between two places.
  std::array<int, 2> between(double from, double to) const {
    const double middle = (centre - axis.origin) * per_cell;
    const int first = static_cast<int>(std::ceil(middle + from * per_cell));
    const int last = static_cast<int>(std::floor(middle + to * per_cell));
    const int period = axis.highest - axis.lowest + 1;
    if (axis.periodic && last - first >= period) {
      const int half = static_cast<int>(std::ceil(middle - 0.5 * period));
      return {std::max(half, first), std::min(half + period - 1, last)};
    }
    if (axis.periodic) return {first, last};
    return {std::max(first, axis.lowest), std::min(last, axis.highest)};
  }
  /// Of a point less than a period beyond an end.
  int wrapped(int n) const {
    const int period = axis.highest - axis.lowest + 1;
    return !axis.periodic ? n : n < axis.lowest ? n + period : n > axis.highest ? n - period : n;
  }
  bool inner(int n) const { return axis.periodic || (n > axis.lowest && n < axis.highest); }
};

/// Runs of points within `radius` [L] of a centre, each in one row of this block: take(plane and
/// row of the block, first point, end, r) with r the first one's place from the centre.
template <class Take>
void for_runs_within(const std::array<StencilAxis, 3>& axes, const Decomposition& decomposition,
                     const Vec3& centre, double radius, Take take) {
  const PointsAlong x{axes[0], centre[0]}, y{axes[1], centre[1]}, z{axes[2], centre[2]};
  const auto half_chord = [](double half, double across) {
    return std::sqrt(std::max(half * half - across * across, 0.0));
  };
  const auto [low, high] = y.within(radius);
  for (int j = low; j <= high; ++j) {
    if (!decomposition.holds_plane(y.wrapped(j))) continue;
    const double disc = half_chord(radius, y.place(j));
    const auto [back, front] = z.within(disc);
    for (int k = back; k <= front; ++k) {
      if (!decomposition.holds_row(z.wrapped(k))) continue;
      const auto [left, right] = x.within(half_chord(disc, z.place(k)));
      for (int i = left; i <= right;) {  // a row through the seam of periodic x is two
        const int first = x.wrapped(i), end = std::min(first + right - i, x.axis.highest) + 1;
        take(y.wrapped(j) - decomposition.first(), z.wrapped(k) - decomposition.first_row(), first,
             end, Vec3(x.place(i), y.place(j), z.place(k)));
        i += end - first;
      }
    }
  }
}

}  // namespace bedload
