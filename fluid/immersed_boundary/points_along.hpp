#pragma once

#include <algorithm>
#include <array>
#include <cmath>

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

}  // namespace bedload
