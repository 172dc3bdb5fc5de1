#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/fluid_change.hpp"
#include "fluid/immersed_boundary/points_along.hpp"
#include "fluid/kernels/prefetch.hpp"

namespace bedload {

/// How deep under a sphere's surface its rigid core begins, in cells: below the cells that markers
/// reach (retraction 0.4, kernel 1.5, half a cell between components).
constexpr double core_depth = 3.0;

/// Radius of the core, in cells; 0 up to D/h = 6.
inline double core_radius(double radius_in_cells) {
  return std::max(radius_in_cells - core_depth, 0.0);
}

/// The fluid in a sphere's core gets the sphere's motion, u = U + omega x r at r from the centre.
///
/// Markers hold the fluid on average over their kernel only. What is free to circulate inside leaks
/// through them, the more the larger the Reynolds number: the wake's low pressure draws on it.
///
/// @param radius of the core [L]  @return what this block's cells have got
template <class Real>
FluidChange carry_core(Field<Real>& velocity, const Grid& grid, const Decomposition& decomposition,
                       const SphereState& sphere, double radius) {
  struct Run {
    Real* u;
    int count;
    Vec3 first;  ///< from the centre [L]
  };
  std::vector<Run> runs;
  FluidChange sum;
  for (int c = 0; c < 3; ++c) {
    const auto along = [&](int d) { return stencil_axis(grid, c, d); };
    runs.clear();  // rows are far from each other: all of them are asked for before one is taken
    for_runs_within({along(0), along(1), along(2)}, decomposition, sphere.position, radius,
                    [&](int j, int k, int first, int end, const Vec3& r) {
                      Real* u = velocity.row(j, k, c) + first;
                      ask_to_write(u, static_cast<std::size_t>(end - first));
                      runs.push_back({u, end - first, r});
                    });
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    Vec3 slope = Vec3::Zero();  // (omega x r)_c = omega_a r_b - omega_b r_a
    slope[b] = sphere.angular_velocity[a];
    slope[a] = -sphere.angular_velocity[b];
    for (const auto& [u, count, r] : runs) {
      double change = 0.0, x_change = 0.0;
      const double at_first = sphere.velocity[c] + slope.dot(r);
      for (int i = 0; i < count; ++i) {
        const double x = i * grid.h, before = static_cast<double>(u[i]);
        u[i] = static_cast<Real>(at_first + slope[0] * x);
        const double more = static_cast<double>(u[i]) - before;
        change += more;
        x_change += x * more;
      }
      sum.add(c, change, change * r + Vec3(x_change, 0.0, 0.0));
    }
  }
  return sum;
}

}  // namespace bedload
