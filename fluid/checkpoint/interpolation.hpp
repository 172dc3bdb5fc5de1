#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace bedload {

/// Linear interpolation at one point from two stored values and, at a wall, from what the wall
/// says:  value = lower_weight q[lower] + upper_weight q[upper] + wall_weight q_wall.
struct LinearStencil {
  int lower = 0, upper = 0;
  double lower_weight = 1.0, upper_weight = 0.0;
  std::array<double, 2> wall_weight{};  ///< of the lower and the upper wall's value
};

/// How a quantity continues beyond the last stored point towards a wall.
///   mirrored:  q(-y) = q(y)                (free slip, pressure)
///   opposed:   q(-y) = 2 q_wall - q(y)     (no slip: the wall lies half a cell outside)
///   on_wall:   the next point is the wall itself, where q = q_wall (the normal component)
enum class Continuation { periodic, mirrored, opposed, on_wall };

/// Where the stored points of one direction lie, q[n] at (n + offset) h with n = 0 .. points - 1:
/// offset 1/2 for cell centres, 1 for upper faces. On stretched y `at` has the places instead, from
/// the one that stands beyond the lower end (n = -1) to the one beyond the upper end.
struct PointRow {
  int points;
  double h;
  double offset;
  std::array<Continuation, 2> ends;
  std::vector<double> at{};

  /// n of a stored point, fractions in between.
  double index_of(double position) const {
    if (at.empty()) return position / h - offset;
    const auto above = std::upper_bound(at.begin() + 1, at.end() - 1, position);
    return static_cast<double>(above - at.begin()) - 2.0 +
           (position - *(above - 1)) / (*above - *(above - 1));
  }
};

/// The row of stretched points with these faces, from wall to wall: cell centres, or upper faces.
inline PointRow stretched_points(const std::vector<double>& faces, bool on_faces,
                                 const std::array<Continuation, 2>& ends) {
  PointRow row{static_cast<int>(faces.size()) - 1, 0.0, 0.0, ends, {}};
  const std::size_t n = faces.size() - 1;
  if (on_faces) {
    row.at = faces;
    row.at.push_back(2.0 * faces[n] - faces[n - 1]);
    return row;
  }
  for (std::size_t j = 0; j < n; ++j) row.at.push_back(0.5 * (faces[j] + faces[j + 1]));
  row.at.insert(row.at.begin(), 2.0 * faces.front() - row.at.front());
  row.at.push_back(2.0 * faces.back() - row.at.back());
  return row;
}

/// The stencil that gives q at `position` (0 <= position <= points h). Second order; exact where
/// `position` is a stored point.
inline LinearStencil linear_stencil(const PointRow& row, double position) {
  const double scaled = row.index_of(position);
  int below = static_cast<int>(std::floor(scaled));
  double fraction = scaled - below;
  constexpr double on_point = 1e-9;  // of a cell: round-off of two grids that meet
  if (fraction < on_point) fraction = 0.0;
  if (fraction > 1.0 - on_point) {
    ++below;
    fraction = 0.0;
  }
  LinearStencil stencil;
  // Adds `weight` times the value of stored point n, or of what stands for it beyond an end.
  const auto add = [&](int& index, double& index_weight, int n, double weight) {
    const bool below_row = n < 0, above_row = n >= row.points;
    index = std::clamp(n, 0, row.points - 1);
    index_weight = weight;
    if (!below_row && !above_row) return;
    const std::size_t end = above_row ? 1 : 0;
    switch (row.ends[end]) {
      case Continuation::periodic:
        index = (n + row.points) % row.points;
        break;
      case Continuation::mirrored:
        break;
      case Continuation::opposed:
        index_weight = -weight;
        stencil.wall_weight[end] = 2.0 * weight;
        break;
      case Continuation::on_wall:
        index_weight = 0.0;
        stencil.wall_weight[end] = weight;
        break;
    }
  };
  add(stencil.lower, stencil.lower_weight, below, 1.0 - fraction);
  add(stencil.upper, stencil.upper_weight, fraction > 0.0 ? below + 1 : below, fraction);
  return stencil;
}

}  // namespace bedload
