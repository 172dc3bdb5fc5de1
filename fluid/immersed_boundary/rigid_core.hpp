#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"

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

/// Runs of cells of one velocity component, each in one row of this block, whose values lie within
/// `radius` [L] of a centre: take(row's first value, first cell, end, r) with r the place of the
/// first cell's value from the centre. Walls' own faces are none of them.
template <class Real, class Take>
void for_runs_within(Field<Real>& velocity, const Grid& grid, const Decomposition& decomposition,
                     int component, const Vec3& centre, double radius, Take take) {
  const double h = grid.h;
  const auto distance = [&](int direction, int cell) {
    return (direction == component ? grid.face(cell) : grid.centre(cell)) - centre[direction];
  };
  const auto cells_within = [&](int direction, double half) {
    const double first = -distance(direction, 0) / h;
    std::array<int, 2> range{static_cast<int>(std::ceil(first - half / h)),
                             static_cast<int>(std::floor(first + half / h))};
    if (!grid.periodic(direction)) {
      const int last = grid.cells[static_cast<std::size_t>(direction)] - 1;
      range = {std::max(range[0], 0), std::min(range[1], direction == component ? last - 1 : last)};
    }
    return range;
  };
  const auto wrapped = [&](int direction, int cell) {  // a sphere is smaller than the box
    const int n = grid.cells[static_cast<std::size_t>(direction)];
    return cell < 0 ? cell + n : cell < n ? cell : cell - n;
  };
  const int nx = grid.cells[0];
  const auto [low, high] = cells_within(1, radius);
  for (int j = low; j <= high; ++j) {
    const int plane = wrapped(1, j);
    if (!decomposition.holds_plane(plane)) continue;
    const double y = distance(1, j), disc = std::sqrt(std::max(radius * radius - y * y, 0.0));
    const auto [back, front] = cells_within(2, disc);
    for (int k = back; k <= front; ++k) {
      if (!decomposition.holds_row(wrapped(2, k))) continue;
      const double z = distance(2, k);
      const auto [left, right] = cells_within(0, std::sqrt(std::max(disc * disc - z * z, 0.0)));
      Real* row = velocity.row(plane - decomposition.first(),
                               wrapped(2, k) - decomposition.first_row(), component);
      for (int i = left; i <= right;) {  // a row through the seam of periodic x is two
        const int first = wrapped(0, i), end = std::min(first + right + 1 - i, nx);
        take(row, first, end, Vec3(distance(0, i), y, z));
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
