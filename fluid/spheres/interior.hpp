#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "fluid/decomposition.hpp"
#include "fluid/field.hpp"
#include "fluid/grid.hpp"
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
/// Here for a row of cells along x at once: each face between two cells hands its four corners'
/// sums to both.
class VolumeShare {
 public:
  /// `cells` cells of a row at distance `y`, `z` from the sphere's centre; `x` is the distance of
  /// the first cell's centre along the row [L].
  const std::vector<double>& row(double radius, double h, double x, double y, double z, int cells) {
    const auto faces = static_cast<std::size_t>(cells) + 1;
    inside_.assign(faces, 0.0);
    both_.assign(faces, 0.0);
    share_.resize(static_cast<std::size_t>(cells));
    for (const double corner_y : {y - 0.5 * h, y + 0.5 * h})
      for (const double corner_z : {z - 0.5 * h, z + 0.5 * h}) {
        const double across = corner_y * corner_y + corner_z * corner_z;
        for (std::size_t f = 0; f < faces; ++f) {
          const double corner_x = x + (static_cast<double>(f) - 0.5) * h;
          const double phi = std::sqrt(corner_x * corner_x + across) - radius;
          inside_[f] += std::max(-phi, 0.0);
          both_[f] += std::abs(phi);
        }
      }
    for (std::size_t i = 0; i + 1 < faces; ++i)
      share_[i] = (inside_[i] + inside_[i + 1]) / (both_[i] + both_[i + 1]);
    return share_;
  }

 private:
  std::vector<double> inside_, both_, share_;
};

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

/// The sums of one component inside a sphere, over this rank's cells.
template <class Real>
InteriorSums interior_sums(const Field<Real>& velocity, const Grid& grid,
                           const Decomposition& slabs, int component, const Vec3& centre,
                           double radius, VolumeShare& share) {
  const double h = grid.h;
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
  const auto near_edge = [h](double centre_distance) {
    return std::max(std::abs(centre_distance) - 0.5 * h, 0.0);
  };

  InteriorSums sums;
  const int nx = grid.cells[0];
  const auto [first_plane, last_plane] = cells_within(1, radius);
  for (int j = first_plane; j <= last_plane; ++j) {
    const int plane = wrapped(1, j);
    if (!slabs.holds_plane(plane)) continue;
    const double y = distance(1, j), edge_y = near_edge(y);
    const double disc = radius * radius - edge_y * edge_y;
    const auto [first_row, last_row] = cells_within(2, std::sqrt(std::max(disc, 0.0)));
    for (int k = first_row; k <= last_row; ++k) {
      const double z = distance(2, k), edge_z = near_edge(z);
      const int row_here = wrapped(2, k);
      if (edge_z * edge_z >= disc || !slabs.holds_row(row_here)) continue;
      const auto [first, last] = cells_within(0, std::sqrt(disc - edge_z * edge_z));
      if (last < first) continue;
      const std::vector<double>& alpha =
          share.row(radius, h, distance(0, first), y, z, last - first + 1);
      const Real* row =
          velocity.row(plane - slabs.first(), row_here - slabs.first_row(), component);
      RowSums along;
      int i = wrapped(0, first);
      double x = distance(0, first);
      for (const double weight : alpha) {
        const double weighted = weight * static_cast<double>(row[i]);
        along.cells += weight;
        along.x += weight * x;
        along.xx += weight * x * x;
        along.u += weighted;
        along.xu += weighted * x;
        x += h;
        if (++i == nx) i = 0;
      }
      add_row(sums, along, y, z, component);
    }
  }
  return sums;
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
