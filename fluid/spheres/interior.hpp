#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "fluid/decomposition.hpp"
#include "fluid/field.hpp"
#include "fluid/grid.hpp"
#include "fluid/lanes.hpp"
#include "fluid/sphere.hpp"

namespace bedload {

/// Sums over the cells of one velocity component u, weighted by the share alpha of each cell that
/// lies inside a sphere; x are the two coordinates from its centre that are not along u, in the
/// order (component + 1) mod 3, (component + 2) mod 3.
struct InteriorSums {
  double cells = 0.0;          ///< sum alpha
  double u = 0.0;              ///< sum alpha u
  std::array<double, 2> x{};   ///< sum alpha x
  std::array<double, 2> xx{};  ///< sum alpha x^2
  std::array<double, 2> xu{};  ///< sum alpha x u
};
inline constexpr std::size_t interior_numbers = sizeof(InteriorSums) / sizeof(double);

/// Share of a cell inside a sphere from the distances phi = |x - x_p| - R of its eight corners
/// (Kempe and Froehlich, J. Comput. Phys. 231 (2012), eq. 32):
///
///   alpha = sum_m -phi_m H(-phi_m) / sum_m |phi_m|,   H the Heaviside function.
///
/// Here for `cells` cells of a row at the distances `y`, `z` from the sphere's centre, `x` that of
/// the first cell's centre [L]: each face between two cells hands its four corners' sums to both.
/// Appends the shares.
inline void append_volume_shares(double radius, double h, double x, double y, double z, int cells,
                                 std::vector<double>& shares) {
  const double low_y = y - 0.5 * h, high_y = y + 0.5 * h;
  const double low_z = z - 0.5 * h, high_z = z + 0.5 * h;
  const Eigen::Array4d across(low_y * low_y + low_z * low_z, low_y * low_y + high_z * high_z,
                              high_y * high_y + low_z * low_z, high_y * high_y + high_z * high_z);
  double inside_before = 0.0, both_before = 0.0;
  for (int face = 0; face <= cells; ++face) {
    const double corner = x + (face - 0.5) * h;
    const Eigen::Array4d phi = (across + corner * corner).sqrt() - radius;
    const double inside = (-phi).max(0.0).sum(), both = phi.abs().sum();
    if (face > 0) shares.push_back((inside_before + inside) / (both_before + both));
    inside_before = inside;
    both_before = both;
  }
}

/// The cells of the velocity components inside spheres that lie in this block, with their shares:
/// found once for a place of the spheres, summed over as often as wanted.
class InteriorCells {
 public:
  void clear() {
    rows_.clear();
    shares_.clear();
    begin_ = {0};
  }
  /// Number of (sphere, component) pairs so far.
  std::size_t size() const { return begin_.size() - 1; }

  /// Adds the cells of one component inside one sphere; `field` only tells the layout.
  template <class Real>
  void add(const Field<Real>& field, const Grid& grid, const Decomposition& slabs, int component,
           const Vec3& centre, double radius);

  /// The sums over pair number `n`.
  template <class Real>
  InteriorSums sums(std::size_t n, const Field<Real>& velocity) const;

 private:
  /// A row of cells, those from full_begin to full_end wholly inside.
  struct Row {
    std::ptrdiff_t first;  ///< from row(0, 0, 0)
    std::size_t share;     ///< place of the first share of the others
    double x, y, z;        ///< of the first cell's value, from the centre [L]
    std::int32_t cells, full_begin, full_end, component;
  };

  double h_ = 0.0;
  std::vector<Row> rows_;
  std::vector<double> shares_;  ///< of the cells that are not wholly inside
  std::vector<std::size_t> begin_{0};
};

template <class Real>
void InteriorCells::add(const Field<Real>& field, const Grid& grid, const Decomposition& slabs,
                        int component, const Vec3& centre, double radius) {
  const double h = h_ = grid.h;
  /// Distance of a cell's value from the sphere's centre along a direction.
  const auto distance = [&](int direction, int cell) {
    return (direction == component ? grid.face(cell) : grid.centre(cell)) - centre[direction];
  };
  /// Cells whose box may be within `reach` of the centre, and which exist.
  const auto cells_within = [&](int direction, double reach) {
    const double middle = (centre[direction] - (direction == component ? 1.0 : 0.5) * h) / h;
    std::array<int, 2> range{static_cast<int>(std::ceil(middle - reach / h - 0.5)),
                             static_cast<int>(std::floor(middle + reach / h + 0.5))};
    if (!grid.periodic(direction)) {
      const int last = grid.cells[static_cast<std::size_t>(direction)] - 1;
      range = {std::max(range[0], 0), std::min(range[1], last)};
    }
    return range;
  };
  const auto wrapped = [&](int direction, int cell) {
    const int n = grid.cells[static_cast<std::size_t>(direction)];
    return ((cell % n) + n) % n;
  };
  /// Distances of a cell's nearest and farthest faces.
  const auto nearest_face = [h](double x) { return std::max(std::abs(x) - 0.5 * h, 0.0); };
  const auto farthest_face = [h](double x) { return std::abs(x) + 0.5 * h; };
  const auto square = [](double x) { return x * x; };

  const int nx = grid.cells[0];
  const Real* origin = field.row(0, 0, 0);
  const auto [first_plane, last_plane] = cells_within(1, radius);
  for (int j = first_plane; j <= last_plane; ++j) {
    const int plane = wrapped(1, j);
    if (!slabs.holds_plane(plane)) continue;
    const double y = distance(1, j), disc = square(radius) - square(nearest_face(y));
    const auto [first_row, last_row] = cells_within(2, std::sqrt(std::max(disc, 0.0)));
    for (int k = first_row; k <= last_row; ++k) {
      const double z = distance(2, k), chord = disc - square(nearest_face(z));
      const int row_here = wrapped(2, k);
      if (chord <= 0.0 || !slabs.holds_row(row_here)) continue;
      const auto [first, last] = cells_within(0, std::sqrt(chord));
      // Both faces of a cell that is wholly inside are, with all their corners.
      const double inner = square(radius) - square(farthest_face(y)) - square(farthest_face(z));
      const double half = inner > 0.0 ? std::sqrt(inner) : -1.0;
      int full_begin = first, full_end = first;
      if (half > 0.5 * h) {
        while (full_begin <= last && farthest_face(distance(0, full_begin)) > half) ++full_begin;
        full_end = full_begin;
        while (full_end <= last && farthest_face(distance(0, full_end)) <= half) ++full_end;
      }
      const Real* row = field.row(plane - slabs.first(), row_here - slabs.first_row(), component);
      // A row through the seam of periodic x is two.
      for (int begin = first; begin <= last;) {
        const int there = wrapped(0, begin), end = std::min(last + 1, begin + nx - there);
        const int full_from = std::clamp(full_begin, begin, end);
        const int full_to = std::clamp(full_end, full_from, end);
        rows_.push_back({.first = row - origin + there,
                         .share = shares_.size(),
                         .x = distance(0, begin),
                         .y = y,
                         .z = z,
                         .cells = end - begin,
                         .full_begin = full_from - begin,
                         .full_end = full_to - begin,
                         .component = component});
        for (const auto& [from, to] : {std::pair{begin, full_from}, std::pair{full_to, end}}) {
          if (from == to) continue;
          append_volume_shares(radius, h, distance(0, from), y, z, to - from, shares_);
        }
        begin = end;
      }
    }
  }
  begin_.push_back(rows_.size());
}

/// Sums over one row of cells, from which the moments about any of the axes follow.
struct RowSums {
  double cells = 0.0, x = 0.0, xx = 0.0;  ///< sum of alpha, alpha x, alpha x^2
  double u = 0.0, xu = 0.0;               ///< sum of alpha u, alpha x u
};

/// Adds a row at the constant distances `y`, `z` from the centre.
inline void add_row(InteriorSums& sums, const RowSums& row, double y, double z, int component) {
  sums.cells += row.cells;
  sums.u += row.u;
  for (const std::size_t d : {0u, 1u}) {
    const int place = (component + 1 + static_cast<int>(d)) % 3;
    if (place == 0) {
      sums.x[d] += row.x;
      sums.xx[d] += row.xx;
      sums.xu[d] += row.xu;
    } else {
      const double constant = place == 1 ? y : z;
      sums.x[d] += constant * row.cells;
      sums.xx[d] += constant * constant * row.cells;
      sums.xu[d] += constant * row.u;
    }
  }
}

template <class Real>
InteriorSums InteriorCells::sums(std::size_t n, const Field<Real>& velocity) const {
  InteriorSums total;
  for (std::size_t r = begin_[n]; r < begin_[n + 1]; ++r) {
    const Row& row = rows_[r];
    const Real* u = velocity.row(0, 0, 0) + row.first;
    const double* share = shares_.data() + row.share;
    RowSums sums;
    const auto partly = [&](int from, int to) {
      for (int i = from; i < to; ++i) {
        const double alpha = *share++, x = row.x + h_ * i;
        const double weighted = alpha * static_cast<double>(u[i]);
        sums.cells += alpha;
        sums.x += alpha * x;
        sums.xx += alpha * x * x;
        sums.u += weighted;
        sums.xu += weighted * x;
      }
    };
    partly(0, row.full_begin);
    partly(row.full_end, row.cells);
    // sum x and sum x^2 of equally spaced cells about their middle
    const int count = row.full_end - row.full_begin;
    const double middle = row.x + h_ * (row.full_begin + 0.5 * (count - 1));
    sums.cells += count;
    sums.x += count * middle;
    sums.xx += count * (middle * middle + h_ * h_ * (double(count) * count - 1.0) / 12.0);
    double plain = 0.0, lever = 0.0;
    int i = row.full_begin;
    if (count >= lane_count) {
      Lanes<double> values{}, moments{}, place = i + Lanes<double>{0.0, 1.0, 2.0, 3.0};
      for (; i + lane_count <= row.full_end; i += lane_count, place += lane_count) {
        const Lanes<double> four = load_double(u + i);
        values += four;
        moments += place * four;
      }
      plain = sum_of(values);
      lever = sum_of(moments);
    }
    for (; i < row.full_end; ++i) {
      const double value = static_cast<double>(u[i]);
      plain += value;
      lever += i * value;
    }
    sums.u += plain;
    sums.xu += row.x * plain + h_ * lever;
    add_row(total, sums, row.y, row.z, row.component);
  }
  return total;
}

/// Momentum and angular momentum about its centre of the fluid inside a sphere, per fluid density.
struct InteriorMomentum {
  Vec3 linear = Vec3::Zero();   ///< integral of u dV [L^4/T]
  Vec3 angular = Vec3::Zero();  ///< integral of (x - x_p) x u dV [L^5/T]
};

/// From the sums of the three components over all ranks. Each component is fitted by u = U + s.x,
/// and the exact volume and second moment of the sphere are put in,
///
///   int u_c dV = V U_c,   int x_d u_c dV = V R^2/5 s_cd,
///
/// so that the result is exact for a sphere's own motion wherever it lies between the cells (the
/// plain sums wander by a few parts in a thousand, which a time derivative would turn into noise).
inline InteriorMomentum interior_momentum(const std::array<InteriorSums, 3>& sums, double radius) {
  const double volume = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
  const double second = volume * radius * radius / 5.0;
  InteriorMomentum out;
  for (int c = 0; c < 3; ++c) {
    const InteriorSums& s = sums[static_cast<std::size_t>(c)];
    if (s.cells <= 0.0) continue;
    double at_centre = s.u / s.cells;
    std::array<double, 2> slope{};
    for (std::size_t d = 0; d < 2; ++d) {
      const double spread = s.xx[d] - s.x[d] * s.x[d] / s.cells;
      if (spread > 0.0) slope[d] = (s.xu[d] - s.x[d] * s.u / s.cells) / spread;
      at_centre -= slope[d] * s.x[d] / s.cells;
    }
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    out.linear[c] = volume * at_centre;
    out.angular[a] += second * slope[1];  // (x cross u)_a = x_b u_c - x_c u_b
    out.angular[b] -= second * slope[0];  // (x cross u)_b = x_c u_a - x_a u_c
  }
  return out;
}

}  // namespace bedload
