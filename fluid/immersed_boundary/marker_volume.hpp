#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/marker_list.hpp"

namespace bedload {

/// Distances from another sphere's surface or a wall [cells] up to which a marker has no volume,
/// and from which on it has all of it.
inline constexpr double volume_beside_from = 1.0, volume_beside_to = 2.0;

/// Distances from a second one, up to which a marker stands at a pore, and from which on at a film.
inline constexpr double pore_from = 3.0, pore_to = 4.0;

/// What share of its force a marker's neighbourhood returns to it.
///
/// One loop of interpolation J, forcing and spreading J^T V (V the markers' volumes in cells)
/// changes the slip s at the markers to (1 - J J^T V) s. All entries of A = J J^T are at least
/// zero, so with the row sums V_l = 1 / sum_m A_lm the matrix V A has row sums 1 and, being similar
/// to a symmetric positive one, eigenvalues in [0, 1]: a loop removes slip that is even over a few
/// cells almost wholly and never enhances any, however many surfaces share a support. The sums run
/// over all markers of all spheres, which is what keeps spheres in contact stable. A times one is
/// the interpolation of spread ones, so this costs as much as one forcing loop.
///
/// Where the surface of another sphere, or a wall, is in the same cells, the markers of both would
/// close the gap between them: the kernel lets nothing flow out of it, the more the less slip is
/// left, that is with shorter steps or more loops. So markers there stand for less, and for nothing
/// in between (volume_beside); what the gap does belongs to lubrication.
///
/// The steps below work on a scratch field that is zero before and after. `markers` is a
/// range of indices into the list.

/// 0 up to `from`, 1 beyond `to`, linear in between.
inline double part_between(double distance, double from, double to) {
  return std::clamp((distance - from) / (to - from), 0.0, 1.0);
}

/// Share of its volume that a marker keeps at the distances [cells] `nearest` and `second` from the
/// surfaces of others. Between two surfaces there is a film, which needs room to flow. Between
/// three there is a pore, and what flows through it would not be held if all of them stood back:
/// markers there keep the share `at_pore` (share_at_pores).
inline double volume_beside(double nearest, double second, double at_pore) {
  const double pore = 1.0 - part_between(second, pore_from, pore_to);
  return 1.0 - (1.0 - part_between(nearest, volume_beside_from, volume_beside_to)) *
                   (1.0 - at_pore * pore);
}

/// By how much markers at pores hold the fluid: wholly from ν Δt/h² = 0.2 on. With shorter steps
/// and more loops what the grid resolves of films would grow beyond what there is; with the square
/// root a packing keeps two thirds of its drag or more (README.md, "Pores").
/// @param diffusion_number ν Δt/h² of a step
inline double share_at_pores(double diffusion_number, int loops) {
  return std::min(1.0, std::sqrt(diffusion_number / (0.2 * loops)));
}

/// scratch += J^T 1.
template <class Real>
void spread_ones(const MarkerList<Real>& list, std::span<const int> markers, Field<Real>& scratch) {
  Real* origin = scratch.row(0, 0, 0);
  const auto plane = static_cast<std::ptrdiff_t>(scratch.plane_size());
  for (std::size_t n = 0; n < markers.size(); ++n) {
    if (n + prefetch_ahead < markers.size())
      prefetch(list.stencil[static_cast<std::size_t>(markers[n + prefetch_ahead])], origin);
    spread(list.stencil[static_cast<std::size_t>(markers[n])], Real{1}, origin, plane);
  }
}

/// Empties the cells that spread_ones() filled.
template <class Real>
void clear_supports(const MarkerList<Real>& list, std::span<const int> markers,
                    Field<Real>& scratch) {
  Real* origin = scratch.row(0, 0, 0);
  const auto plane = static_cast<std::ptrdiff_t>(scratch.plane_size());
  for (const int marker : markers)
    clear(list.stencil[static_cast<std::size_t>(marker)], origin, plane);
}

/// The same for all markers of a sphere that this rank handles, by whole rows of cells: markers are
/// so close to each other that clear_supports() would empty each cell several times.
template <class Real>
void clear_around(const SphereState& sphere, const Grid& grid, const Decomposition& decomposition,
                  Field<Real>& scratch) {
  // Two cells beyond the surface, where a wall pushes the support inwards, and half a cell because
  // points lie on centres or faces.
  const double half_width = sphere.radius / grid.h + 2.5;
  const auto middle = [&](int direction) { return sphere.position[direction] / grid.h; };
  /// Those of the points -1 .. count of a direction, ghosts included, that may be reached.
  const auto reached = [&](int direction, int first, int count) {
    const int period = grid.cells[static_cast<std::size_t>(direction)];
    std::vector<int> points;
    for (int n = -1; n <= count; ++n) {
      double way = first + n + 0.75 - middle(direction);
      if (grid.periodic(direction)) way -= period * std::round(way / period);
      if (std::abs(way) <= half_width) points.push_back(n);
    }
    return points;
  };
  // Along x one piece, and where it goes through the seam a second.
  const int nx = grid.cells[0];
  const int low = static_cast<int>(std::ceil(middle(0) - half_width - 0.75));
  const int high = static_cast<int>(std::floor(middle(0) + half_width - 0.75));
  std::array<std::pair<int, int>, 2> pieces{{{std::max(low, -1), std::min(high, nx)}, {0, -1}}};
  if (low < 0) pieces[1] = {std::max(nx + low, -1), nx};
  if (high >= nx) pieces[1] = {-1, std::min(high - nx, nx)};
  const std::vector<int> rows = reached(2, decomposition.first_row(), decomposition.rows());
  for (const int j : reached(1, decomposition.first(), scratch.planes()))
    for (const int k : rows)
      for (int c = 0; c < scratch.components(); ++c)
        for (const auto& [from, to] : pieces)
          std::fill(scratch.row(j, k, c) + from, scratch.row(j, k, c) + to + 1, Real{});
}

/// volume_l = 1 / (before_l + (J scratch)_l); `before` (for the whole list) may be null.
template <class Real>
void weigh(MarkerList<Real>& list, std::span<const int> markers, const Real* before,
           const Field<Real>& scratch) {
  const Real* origin = scratch.row(0, 0, 0);
  const auto plane = static_cast<std::ptrdiff_t>(scratch.plane_size());
  for (std::size_t n = 0; n < markers.size(); ++n) {
    if (n + prefetch_ahead < markers.size())
      prefetch(list.stencil[static_cast<std::size_t>(markers[n + prefetch_ahead])], origin);
    const auto m = static_cast<std::size_t>(markers[n]);
    const Real row_sum =
        (before ? before[m] : Real{}) + interpolate(list.stencil[m], origin, plane);
    list.volume[m] = Real{1} / row_sum;
  }
}

}  // namespace bedload
