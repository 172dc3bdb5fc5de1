#pragma once

#include <cstddef>
#include <span>

#include "fluid/field.hpp"
#include "fluid/spheres/marker_list.hpp"

namespace bedload {

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
/// The steps below work on a scratch field that is zero before and after. `markers` is a
/// range of indices into the list.

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
