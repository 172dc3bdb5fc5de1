#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/grid/sphere_bins.hpp"

namespace bedload {

/// Which mobile spheres are others than they were when last looked at: new ones, ones of another
/// size or density, and ones that are further away than their motion can have carried them (more
/// than a radius in one stage).
class SphereChanges {
 public:
  explicit SphereChanges(Grid grid) : grid_(std::move(grid)) {}

  /// Takes the mobile ones of `spheres` (ascending tags) as they are now; returns the tags of those
  /// that are others, ascending.
  std::vector<std::int64_t> update(std::span<const SphereState> spheres) {
    std::vector<std::int64_t> changed;
    std::vector<SphereState> now;
    std::size_t n = 0;
    for (const SphereState& sphere : spheres) {
      if (!sphere.mobile) continue;
      while (n < before_.size() && before_[n].tag < sphere.tag) ++n;
      if (n == before_.size() || is_another(before_[n], sphere)) changed.push_back(sphere.tag);
      now.push_back(sphere);
    }
    before_ = std::move(now);
    return changed;
  }

 private:
  bool is_another(const SphereState& before, const SphereState& now) const {
    return before.tag != now.tag || before.radius != now.radius || before.density != now.density ||
           shortest_way(grid_, before.position, now.position).norm() > now.radius;
  }

  Grid grid_;
  std::vector<SphereState> before_;
};

}  // namespace bedload
