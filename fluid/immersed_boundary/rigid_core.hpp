#pragma once

#include <algorithm>
#include <cmath>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/points_along.hpp"

namespace bedload {

/// How deep under a sphere's surface its rigid core begins, in cells: below the cells that markers
/// reach (retraction 0.4, kernel 1.5, half a cell between components).
constexpr double core_depth = 3.0;

/// Radius of the core, in cells; 0 up to D/h = 6.
inline double core_radius(double radius_in_cells) {
  return std::max(radius_in_cells - core_depth, 0.0);
}

/// What the cells of a core have got, velocity times cells, and its moment about the centre [L].
struct CoreChange {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};

/// Runs of points of one velocity component, each in one row of this block, within `radius` [L] of
/// a centre: take(row's point 0, first point, end, r) with r the first one's place from the centre.
template <class Real, class Take>
void for_runs_within(Field<Real>& velocity, const Grid& grid, const Decomposition& decomposition,
                     int component, const Vec3& centre, double radius, Take take) {
  const auto along = [&](int d) {
    return PointsAlong{stencil_axis(grid, component, d), centre[d]};
  };
  const PointsAlong x = along(0), y = along(1), z = along(2);
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
      Real* row = velocity.row(y.wrapped(j) - decomposition.first(),
                               z.wrapped(k) - decomposition.first_row(), component);
      for (int i = left; i <= right;) {  // a row through the seam of periodic x is two
        const int first = x.wrapped(i), end = std::min(first + right - i, x.axis.highest) + 1;
        take(row, first, end, Vec3(x.place(i), y.place(j), z.place(k)));
        i += end - first;
      }
    }
  }
}

/// The fluid in a sphere's core gets the sphere's motion, u = U + omega x r at r from the centre.
///
/// Markers hold the fluid on average over their kernel only. What is free to circulate inside leaks
/// through them, the more the larger the Reynolds number: the wake's low pressure draws on it.
///
/// @param radius of the core [L]  @return what this block's cells have got
template <class Real>
CoreChange carry_core(Field<Real>& velocity, const Grid& grid, const Decomposition& decomposition,
                      const SphereState& sphere, double radius) {
  CoreChange sum;
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    Vec3 slope = Vec3::Zero();  // (omega x r)_c = omega_a r_b - omega_b r_a
    slope[b] = sphere.angular_velocity[a];
    slope[a] = -sphere.angular_velocity[b];
    const auto take = [&](Real* u, int first, int end, const Vec3& r) {
      double change = 0.0, x_change = 0.0;
      const double at_first = sphere.velocity[c] + slope.dot(r);
      for (int i = first; i < end; ++i) {
        const double x = (i - first) * grid.h, before = static_cast<double>(u[i]);
        u[i] = static_cast<Real>(at_first + slope[0] * x);
        const double more = static_cast<double>(u[i]) - before;
        change += more;
        x_change += x * more;
      }
      const Vec3 moment = change * r + Vec3(x_change, 0.0, 0.0);  // sum of r f_c
      sum.linear[c] += change;
      sum.angular[a] += moment[b];
      sum.angular[b] -= moment[a];
    };
    for_runs_within(velocity, grid, decomposition, c, sphere.position, radius, take);
  }
  return sum;
}

}  // namespace bedload
