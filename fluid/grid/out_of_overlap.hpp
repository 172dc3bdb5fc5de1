#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"

namespace bedload {

/// The spheres where they only touch: at position - overlap, inside the periodic box [L].
inline std::vector<SphereState> out_of_overlap(const Grid& grid,
                                               std::span<const SphereState> spheres) {
  std::vector<SphereState> touching(spheres.begin(), spheres.end());
  for (SphereState& sphere : touching) {
    if (sphere.overlap.isZero(0.0)) continue;
    sphere.position -= sphere.overlap;
    sphere.overlap.setZero();
    for (int d = 0; d < 3; ++d) {
      const double length = grid.length[static_cast<std::size_t>(d)];
      if (grid.periodic(d)) sphere.position[d] -= length * std::floor(sphere.position[d] / length);
    }
  }
  return touching;
}

}  // namespace bedload
