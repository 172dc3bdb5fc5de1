#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fluid/grid/field.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/fluid_change.hpp"
#include "fluid/immersed_boundary/marker_layout.hpp"
#include "fluid/immersed_boundary/marker_list.hpp"
#include "fluid/immersed_boundary/stencil.hpp"

namespace bedload {

/// Component c of U + omega x r.
inline double surface_velocity(const SphereState& sphere, const Vec3& r, int c) {
  const int a = (c + 1) % 3, b = (c + 2) % 3;
  return sphere.velocity[c] + sphere.angular_velocity[a] * r[b] - sphere.angular_velocity[b] * r[a];
}

/// Slip of markers, of those that have a volume: the others stand back beside another sphere or
/// a wall.
struct SlipSums {
  double max = 0.0, squares = 0.0;
  /// Largest slip of the markers that stand for a cell or more: what loops can take.
  double within_reach = 0.0;
  std::int64_t components = 0;  ///< that were summed, three a marker
};

/// Calls use(l, U_l - (J u)_l) for all markers of a list and adds their slip to `sums`.
template <class Real, class StateOf, class Use>
void for_slips(const MarkerList<Real>& list, const Field<Real>& velocity, int component,
               StateOf state_of, const std::vector<MarkerLayout>& layouts, SlipSums& sums,
               Use use) {
  const Real* origin = velocity.row(0, 0, 0);
  const auto plane = static_cast<std::ptrdiff_t>(velocity.plane_size());
  Real largest{}, within_reach{};
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
      if (list.volume[m] == Real{}) continue;
      ++sums.components;
      largest = std::max(largest, std::abs(slip));
      if (list.volume[m] >= Real{1}) within_reach = std::max(within_reach, std::abs(slip));
      square += static_cast<double>(slip) * static_cast<double>(slip);
    }
    sums.squares += square;
  }
  sums.max = std::max(sums.max, static_cast<double>(largest));
  sums.within_reach = std::max(sums.within_reach, static_cast<double>(within_reach));
}

/// u += J^T increment. Adds what the fluid gets to given_of(number of the sphere).
template <class Real, class GivenOf>
void spread_increments(const MarkerList<Real>& list, Field<Real>& velocity, int component,
                       GivenOf given_of, const std::vector<MarkerLayout>& layouts) {
  Real* origin = velocity.row(0, 0, 0);
  const auto plane = static_cast<std::ptrdiff_t>(velocity.plane_size());
  for (const auto& range : list.ranges) {
    const MarkerLayout& layout = layouts[static_cast<std::size_t>(range.layout)];
    double sum = 0.0;
    Vec3 moment = Vec3::Zero();
    for (int n = range.begin; n < range.end; ++n) {
      const auto m = static_cast<std::size_t>(n);
      if (m + prefetch_ahead < list.stencil.size())
        prefetch(list.stencil[m + prefetch_ahead], origin);
      spread(list.stencil[m], list.increment[m], origin, plane);
      const double change = static_cast<double>(list.increment[m]);
      sum += change;
      moment += change * layout.offsets[static_cast<std::size_t>(list.offset[m])];
    }
    given_of(range.sphere).add(component, sum, moment);
  }
}

}  // namespace bedload
