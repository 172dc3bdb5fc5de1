#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/immersed_boundary/kernel.hpp"
#include "fluid/kernels/independent_loop.hpp"
#include "fluid/kernels/simd.hpp"

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

/// The same for many markers, as arrays. The weight of the nearest point is 1 less the other two.
template <class Real>
struct AxisWeightArrays {
  std::vector<std::int32_t> nearest;
  std::vector<Real> lower, upper;        ///< weights of the points nearest-1 and nearest+1
  std::int32_t lowest = 0, highest = 0;  ///< of the nearest points
};

/// axis_weights() of markers at `centre` + offsets[m] [L], the centre inside the box.
template <class Real>
void find_weights(const StencilAxis& axis, double centre, const std::vector<double>& offsets,
                  AxisWeightArrays<Real>& out) {
  const std::size_t count = offsets.size();
  out.nearest.resize(count);
  out.lower.resize(count);
  out.upper.resize(count);
  const double shift = (centre - axis.origin) / axis.h, scale = 1.0 / axis.h;
  BEDLOAD_INDEPENDENT_LOOP
  for (std::size_t m = 0; m < count; ++m) {
    const double q = shift + scale * offsets[m], nearest = std::floor(q + 0.5);
    const Real d = static_cast<Real>(q - nearest), outer = Real{1} - roma_middle_weight(d);
    out.lower[m] = Real{0.5} * (outer - d);
    out.upper[m] = Real{0.5} * (outer + d);
    out.nearest[m] = static_cast<std::int32_t>(nearest);
  }
  const auto find_ends = [&out] {
    std::int32_t lowest = out.nearest.front(), highest = lowest;
    for (const std::int32_t nearest : out.nearest) {
      lowest = std::min(lowest, nearest);
      highest = std::max(highest, nearest);
    }
    out.lowest = lowest, out.highest = highest;
  };
  find_ends();
  if (out.lowest > axis.lowest && out.highest < axis.highest) return;
  const std::int32_t period = axis.highest - axis.lowest + 1;
  for (std::size_t m = 0; m < count; ++m) {
    std::int32_t& nearest = out.nearest[m];
    if (axis.periodic) {
      nearest += nearest < axis.lowest ? period : 0;
      nearest -= nearest > axis.highest ? period : 0;
    } else if (nearest <= axis.lowest || nearest >= axis.highest) {
      const AxisWeights at_wall = axis_weights(axis, centre + offsets[m]);
      nearest = at_wall.nearest;
      out.lower[m] = static_cast<Real>(at_wall.weight[0]);
      out.upper[m] = static_cast<Real>(at_wall.weight[2]);
    }
  }
  find_ends();
}

/// Where one marker meets one velocity component: the outer two of three weights per direction (the
/// one in the middle is 1 less these, in Real, too) and the place in the field's memory. One cache
/// line in double precision.
template <class Real>
struct Stencil {
  std::int32_t first;                ///< of point (nearest - 1 in x, y and z), from row(0, 0, 0)
  std::array<std::int32_t, 2> rows;  ///< from the first z row to the second and the third
  std::array<Real, 2> x, y, z;

  static std::array<Real, 3> all(const std::array<Real, 2>& outer) {
    return {outer[0], Real{1} - outer[0] - outer[1], outer[1]};
  }
  /// Ends with a zero, so that a row is four values, a vector register's length.
  [[gnu::always_inline]] SimdVector<Real> x_line() const {
    return SimdVector<Real>{x[0], Real{1} - x[0] - x[1], x[1], Real{}};
  }
};

/// Interpolation: U = sum_i x_i sum_j y_j sum_k z_k u_ijk. `origin` is the field's row(0, 0, 0),
/// `plane` the distance of two y planes in memory.
template <class Real>
inline Real interpolate(const Stencil<Real>& s, const Real* origin, std::ptrdiff_t plane) {
  const std::array<Real, 3> y = s.all(s.y), z = s.all(s.z);
  const Real* first = origin + s.first;
  const auto across_z = [&](const Real* row) __attribute__((always_inline)) {
    return z[0] * load(row) + z[1] * load(row + s.rows[0]) + z[2] * load(row + s.rows[1]);
  };
  const SimdVector<Real> line =
      y[0] * across_z(first) + y[1] * across_z(first + plane) + y[2] * across_z(first + 2 * plane);
  const SimdVector<Real> product = line * s.x_line();
  return (product[0] + product[1]) + (product[2] + product[3]);
}

/// Spreading, the transpose: u_ijk += x_i y_j z_k value.
template <class Real>
inline void spread(const Stencil<Real>& s, Real value, Real* origin, std::ptrdiff_t plane) {
  const std::array<Real, 3> y = s.all(s.y), z = s.all(s.z);
  const std::array<std::ptrdiff_t, 3> rows{0, s.rows[0], s.rows[1]};
  const SimdVector<Real> line = value * s.x_line();
  Real* corner = origin + s.first;
  for (std::size_t m = 0; m < 3; ++m, corner += plane) {
    const SimdVector<Real> in_plane = y[m] * line;
    for (std::size_t n = 0; n < 3; ++n)
      store(corner + rows[n], load(corner + rows[n]) + z[n] * in_plane);
  }
}

/// u_ijk = 0 where the marker spreads.
template <class Real>
inline void clear(const Stencil<Real>& s, Real* origin, std::ptrdiff_t plane) {
  Real* corner = origin + s.first;
  for (int m = 0; m < 3; ++m, corner += plane)
    for (const std::int32_t row : {0, s.rows[0], s.rows[1]})
      store(corner + row, SimdVector<Real>{});
}

/// How many markers before its turn a support is asked for.
inline constexpr std::size_t prefetch_ahead = 8;

/// Asks for the rows of the support's lowest plane: markers come in descending order, so these are
/// the ones that are not in cache yet.
template <class Real>
inline void prefetch(const Stencil<Real>& s, const Real* origin) {
  const Real* row = origin + s.first;
  __builtin_prefetch(row, 1);
  __builtin_prefetch(row + s.rows[0], 1);
  __builtin_prefetch(row + s.rows[1], 1);
}

}  // namespace bedload
