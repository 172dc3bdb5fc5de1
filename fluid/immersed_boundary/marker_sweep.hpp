#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "fluid/grid/field.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/marker_layout.hpp"
#include "fluid/immersed_boundary/marker_list.hpp"
#include "fluid/immersed_boundary/stencil.hpp"

namespace bedload {

/// Component c of U + omega x r.
inline double surface_velocity(const SphereState& sphere, const Vec3& r, int c) {
  const int a = (c + 1) % 3, b = (c + 2) % 3;
  return sphere.velocity[c] + sphere.angular_velocity[a] * r[b] - sphere.angular_velocity[b] * r[a];
}

/// Calls use(l, U_l - (J u)_l) for all markers of a list; returns the largest slip and adds the
/// slips' squares to `squares`.
template <class Real, class StateOf, class Use>
double for_slips(const MarkerList<Real>& list, const Field<Real>& velocity, int component,
                 StateOf state_of, const std::vector<MarkerLayout>& layouts, double& squares,
                 Use use) {
  const Real* origin = velocity.row(0, 0, 0);
  const auto plane = static_cast<std::ptrdiff_t>(velocity.plane_size());
  Real largest{};
  for (const auto& range : list.ranges) {
    const SphereState& sphere = state_of(range.sphere);
    const MarkerLayout& layout = layouts[static_cast<std::size_t>(range.layout)];
    double square = 0.0;
    for (int n = range.begin; n < range.end; ++n) {
      const auto m = static_cast<std::size_t>(n);
      if (m + prefetch_ahead < list.stencil.size())
        prefetch(list.stencil[m + prefetch_ahead], origin);
      const Vec3& offset = layout.offsets[static_cast<std::size_t>(list.offset[m])];
      const Real target = static_cast<Real>(surface_velocity(sphere, offset, component));
      const Real slip = target - interpolate(list.stencil[m], origin, plane);
      use(m, slip);
      largest = std::max(largest, std::abs(slip));
      square += static_cast<double>(slip) * static_cast<double>(slip);
    }
    squares += square;
  }
  return static_cast<double>(largest);
}

/// u += J^T increment. Adds up the increments of a stage's loops, of which this may be the first.
template <class Real>
void spread_increments(MarkerList<Real>& list, Field<Real>& velocity, bool first_loop) {
  Real* origin = velocity.row(0, 0, 0);
  const auto plane = static_cast<std::ptrdiff_t>(velocity.plane_size());
  for (std::size_t m = 0; m < list.stencil.size(); ++m) {
    if (m + prefetch_ahead < list.stencil.size())
      prefetch(list.stencil[m + prefetch_ahead], origin);
    spread(list.stencil[m], list.increment[m], origin, plane);
    list.applied[m] = (first_loop ? Real{} : list.applied[m]) + list.increment[m];
  }
}

}  // namespace bedload
