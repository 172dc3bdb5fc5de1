#pragma once

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "fluid/grid/sphere.hpp"

namespace bedload {

/// Number of markers on a sphere of `radius_in_cells` = R/h: `density` times the one with which
/// each stands for about one cell's volume, N = pi/3 (12 R^2/h^2 + 1) (Uhlmann, J. Comput. Phys.
/// 209 (2005), eq. 21: a shell of thickness h around the surface, divided by h^3).
inline int marker_count(double radius_in_cells, double density) {
  const double r = radius_in_cells;
  return static_cast<int>(std::ceil(density * std::numbers::pi / 3.0 * (12.0 * r * r + 1.0)));
}

/// How far the markers are pulled in under the surface, in cells, so that the drag of an array of
/// spheres is exact to second order (README.md; the idea: Breugem, J. Comput. Phys. 231 (2012)):
///
///   0.29 + h/D + 0.13 (r/R)^2,
///
/// r the radius of the rigid core, without which more leaks through the markers; 0: there is none.
inline double default_retraction(double radius_in_cells, double core_in_cells) {
  const double share = core_in_cells / radius_in_cells;
  return 0.29 + 0.5 / radius_in_cells + 0.13 * share * share;
}

/// `count` points spread evenly on the unit sphere: a golden-angle spiral about y with equal steps
/// in y, so that each point has the same area. Beginning half a step below the pole keeps the
/// neighbours of the poles as far apart as all others. The order goes from top to bottom, which is
/// the order of the planes in memory.
inline std::vector<Vec3> spiral_points(int count) {
  assert(count > 0);
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<Vec3> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int n = 0; n < count; ++n) {
    const double y = 1.0 - (2.0 * n + 1.0) / count;
    const double ring = std::sqrt(1.0 - y * y), angle = golden_angle * n;
    points.emplace_back(ring * std::cos(angle), y, ring * std::sin(angle));
  }
  return points;
}

/// Markers of one sphere size relative to its centre [L]; the same for all spheres of that radius,
/// and not turned with them (a sphere's surface looks the same from all sides).
struct MarkerLayout {
  double radius = 0.0;                       ///< of the sphere [L]
  std::vector<Vec3> offsets;                 ///< from the centre to the markers [L]
  std::array<std::vector<double>, 3> along;  ///< the same, direction by direction
};

/// Layout for spheres of `radius` on cells of edge `h`; `retraction` in cells, negative: the
/// default of spheres whose rigid core has `core_in_cells`; `density` as in marker_count().
inline MarkerLayout make_marker_layout(double radius, double h, double retraction,
                                       double core_in_cells, double density) {
  const double cells = radius / h;
  const double pulled_in =
      (retraction < 0.0 ? default_retraction(cells, core_in_cells) : retraction) * h;
  MarkerLayout layout{.radius = radius, .offsets = spiral_points(marker_count(cells, density))};
  for (Vec3& offset : layout.offsets) {
    offset *= std::max(radius - pulled_in, 0.0);
    for (int d = 0; d < 3; ++d) layout.along[static_cast<std::size_t>(d)].push_back(offset[d]);
  }
  return layout;
}

}  // namespace bedload
