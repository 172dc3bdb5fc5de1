#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "fluid/field.hpp"
#include "fluid/sphere.hpp"
#include "fluid/spheres/marker_layout.hpp"
#include "fluid/spheres/marker_list.hpp"
#include "fluid/spheres/stencil.hpp"

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
      const Vec3& arm = layout.arms[static_cast<std::size_t>(list.arm[m])];
      const Real target = static_cast<Real>(surface_velocity(sphere, arm, component));
      const Real slip = target - interpolate(list.stencil[m], origin, plane);
      use(m, slip);
      largest = std::max(largest, std::abs(slip));
      square += static_cast<double>(slip) * static_cast<double>(slip);
    }
    squares += square;
  }
  return static_cast<double>(largest);
}

/// u += J^T change.
template <class Real>
void spread_change(MarkerList<Real>& list, Field<Real>& velocity) {
  Real* origin = velocity.row(0, 0, 0);
  const auto plane = static_cast<std::ptrdiff_t>(velocity.plane_size());
  for (std::size_t m = 0; m < list.stencil.size(); ++m) {
    if (m + prefetch_ahead < list.stencil.size())
      prefetch(list.stencil[m + prefetch_ahead], origin);
    spread(list.stencil[m], list.change[m], origin, plane);
    list.given[m] += list.change[m];
  }
}

}  // namespace bedload
