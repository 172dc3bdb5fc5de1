#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "fluid/field.hpp"
#include "fluid/grid.hpp"
#include "fluid/spheres/kernel.hpp"

namespace bedload {

/// The points of one staggered grid along one direction that a marker may use.
struct StencilAxis {
  double origin = 0.0;  ///< position of point 0 [L]
  double h = 0.0;       ///< spacing [L]
  int lowest = 0;       ///< first and last point that the fluid can move
  int highest = 0;
  bool periodic = false;  ///< point highest + 1 is point lowest again
};

/// Axis of velocity component `component` along `direction`. Between walls a component normal to
/// them has no unknown on the wall itself: its upper face n-1 lies there.
inline StencilAxis stencil_axis(const Grid& grid, int component, int direction) {
  const int n = grid.cells[static_cast<std::size_t>(direction)];
  const bool normal = component == direction, periodic = grid.periodic(direction);
  return {.origin = normal ? grid.face(0) : grid.centre(0),
          .h = grid.h,
          .lowest = 0,
          .highest = normal && !periodic ? n - 2 : n - 1,
          .periodic = periodic};
}

/// A marker's part along one direction: the point in the middle of its support (nearest to the
/// marker) and the weights of the points nearest-1, nearest, nearest+1.
struct AxisWeights {
  int nearest = 0;
  std::array<double, 3> weight{};
};

/// Weights of a marker at `position` [L]. A periodic axis wraps `nearest` into its range. At a wall
/// the points beyond it are dropped and the others scaled so that the sum stays 1: whatever a
/// marker spreads arrives in the fluid, and the weights stay positive, at the price of the first
/// moment.
inline AxisWeights axis_weights(const StencilAxis& axis, double position) {
  const double q = (position - axis.origin) / axis.h;
  AxisWeights out;
  out.nearest = static_cast<int>(std::floor(q + 0.5));
  if (axis.periodic) {
    out.weight = roma_weights(q - out.nearest);
    const int period = axis.highest - axis.lowest + 1;
    while (out.nearest < axis.lowest) out.nearest += period;
    while (out.nearest > axis.highest) out.nearest -= period;
    return out;
  }
  out.nearest = std::min(std::max(out.nearest, axis.lowest), axis.highest);
  double sum = 0.0;
  for (int m = 0; m < 3; ++m) {
    const int point = out.nearest + m - 1;
    const bool inside = point >= axis.lowest && point <= axis.highest;
    const double weight = inside ? roma_kernel(q - point) : 0.0;
    out.weight[static_cast<std::size_t>(m)] = weight;
    sum += weight;
  }
  if (sum > 0.0) {
    for (double& weight : out.weight) weight /= sum;
  } else {
    out.weight = {0.0, 1.0, 0.0};
  }
  return out;
}

/// Where one marker meets one velocity component: three weights per direction, and the place in the
/// field's memory. The x weights end with a zero so that loops over x run over four values, a
/// vector register's length.
template <class Real>
struct Stencil {
  std::ptrdiff_t first;              ///< of point (nearest - 1 in x, y and z), from row(0, 0, 0)
  std::array<std::int32_t, 2> rows;  ///< from the first z row to the second and the third
  std::array<Real, 4> x;
  std::array<Real, 3> y, z;
};

/// Stencil of component `component` from its three axis weights; `plane` and `row` are the local
/// indices of the nearest y plane and z row. `field` only tells the layout, and may have fewer
/// planes.
template <class Real>
Stencil<Real> make_stencil(const Field<Real>& field, int component, const AxisWeights& x, int plane,
                           const AxisWeights& y, int row, const AxisWeights& z) {
  const auto as_real = [](const std::array<double, 3>& weight) {
    const Real lower = static_cast<Real>(weight[0]), upper = static_cast<Real>(weight[2]);
    return std::array<Real, 3>{lower, Real{1} - lower - upper, upper};  // sum 1 in Real, too
  };
  Stencil<Real> s{};
  const Real* first = field.row(0, row - 1, component);
  s.first = first - field.row(0, 0, 0) + x.nearest - 1 +
            (plane - 1) * static_cast<std::ptrdiff_t>(field.plane_size());
  for (int n = 0; n < 2; ++n)
    s.rows[static_cast<std::size_t>(n)] =
        static_cast<std::int32_t>(field.row(0, row + n, component) - first);
  const std::array<Real, 3> wx = as_real(x.weight);
  s.x = {wx[0], wx[1], wx[2], Real{}};
  s.y = as_real(y.weight);
  s.z = as_real(z.weight);
  return s;
}

/// Interpolation: U = sum_i sum_j sum_k x_i y_j z_k u_ijk. `origin` is the field's row(0, 0, 0),
/// `plane` the distance of two y planes in memory.
template <class Real>
inline Real interpolate(const Stencil<Real>& s, const Real* origin, std::ptrdiff_t plane) {
  const std::array<std::ptrdiff_t, 3> rows{0, s.rows[0], s.rows[1]};
  std::array<Real, 4> line{};
  for (std::size_t m = 0; m < 3; ++m)
    for (std::size_t n = 0; n < 3; ++n) {
      const Real* row = origin + s.first + static_cast<std::ptrdiff_t>(m) * plane + rows[n];
      const Real weight = s.y[m] * s.z[n];
      for (std::size_t i = 0; i < 4; ++i) line[i] += weight * row[i];
    }
  return (line[0] * s.x[0] + line[1] * s.x[1]) + (line[2] * s.x[2] + line[3] * s.x[3]);
}

/// Spreading, the transpose: u_ijk += x_i y_j z_k value.
template <class Real>
inline void spread(const Stencil<Real>& s, Real value, Real* origin, std::ptrdiff_t plane) {
  const std::array<std::ptrdiff_t, 3> rows{0, s.rows[0], s.rows[1]};
  std::array<Real, 4> line;
  for (std::size_t i = 0; i < 4; ++i) line[i] = value * s.x[i];
  for (std::size_t m = 0; m < 3; ++m)
    for (std::size_t n = 0; n < 3; ++n) {
      Real* row = origin + s.first + static_cast<std::ptrdiff_t>(m) * plane + rows[n];
      const Real weight = s.y[m] * s.z[n];
      for (std::size_t i = 0; i < 4; ++i) row[i] += weight * line[i];
    }
}

/// Sets the support to zero.
template <class Real>
inline void clear(const Stencil<Real>& s, Real* origin, std::ptrdiff_t plane) {
  const std::array<std::ptrdiff_t, 3> rows{0, s.rows[0], s.rows[1]};
  for (std::size_t m = 0; m < 3; ++m)
    for (std::size_t n = 0; n < 3; ++n) {
      Real* row = origin + s.first + static_cast<std::ptrdiff_t>(m) * plane + rows[n];
      for (std::size_t i = 0; i < 3; ++i) row[i] = Real{};
    }
}

}  // namespace bedload
