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
  double cells = 0.0;              ///< sum alpha
  double u = 0.0;                  ///< sum alpha u
  std::array<double, 2> x{};       ///< sum alpha x
  std::array<double, 2> xx{};      ///< sum alpha x^2
  std::array<double, 2> xu{};      ///< sum alpha x u
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
  /// Cells first .. last (not wrapped) of a row at distance `y`, `z` from the sphere's centre; `x`
  /// is the distance of cell `first` along the row [L].
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

/// The sums of one component inside a sphere, over this rank's planes.
template <class Real>
InteriorSums interior_sums(const Field<Real>& velocity, const Grid& grid,
                           const Decomposition& slabs, int component, const Vec3& centre,
                           double radius, VolumeShare& share) {
  const double h = grid.h;
  const auto position = [&](int direction, int cell) {
    return direction == component ? grid.face(cell) : grid.centre(cell);
  };
  std::array<int, 3> first{}, last{};
  for (int d = 0; d < 3; ++d) {
    const auto e = static_cast<std::size_t>(d);
    first[e] = static_cast<int>(std::floor((centre[d] - radius) / h)) - 1;
    last[e] = static_cast<int>(std::floor((centre[d] + radius) / h)) + 1;
    if (!grid.periodic(d)) {
      first[e] = std::max(first[e], 0);
      last[e] = std::min(last[e], grid.cells[e] - 1);
    }
  }
  const auto wrapped = [&](int direction, int cell) {
    const int n = grid.cells[static_cast<std::size_t>(direction)];
    return ((cell % n) + n) % n;
  };

  InteriorSums sums;
  if (first[0] > last[0]) return sums;
  const int a = (component + 1) % 3, b = (component + 2) % 3;
  for (int j = first[1]; j <= last[1]; ++j) {
    const int plane = wrapped(1, j);
    if (!slabs.holds(plane)) continue;
    for (int k = first[2]; k <= last[2]; ++k) {
      Vec3 way{position(0, first[0]), position(1, j), position(2, k)};
      way -= centre;
      const double nearest = std::max(std::abs(way.y()) - 0.5 * h, 0.0);
      const double nearest_z = std::max(std::abs(way.z()) - 0.5 * h, 0.0);
      if (nearest * nearest + nearest_z * nearest_z >= radius * radius) continue;
      const int cells = last[0] - first[0] + 1;
      const std::vector<double>& alpha =
          share.row(radius, h, way.x(), way.y(), way.z(), cells);
      const Real* row = velocity.row(plane - slabs.first(), wrapped(2, k), component);
      const double x0 = way.x();
      for (int i = 0; i < cells; ++i) {
        const double weight = alpha[static_cast<std::size_t>(i)];
        const double u = static_cast<double>(row[wrapped(0, first[0] + i)]);
        way.x() = x0 + i * h;
        const double xa = way[a], xb = way[b];
        sums.cells += weight;
        sums.u += weight * u;
        sums.x[0] += weight * xa;
        sums.x[1] += weight * xb;
        sums.xx[0] += weight * xa * xa;
        sums.xx[1] += weight * xb * xb;
        sums.xu[0] += weight * xa * u;
        sums.xu[1] += weight * xb * u;
      }
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
