#pragma once

#include <span>
#include <vector>

#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/grid/sphere_bins.hpp"

namespace bedload {

/// The spheres where they only touch: at position - overlap, inside the periodic box [L].
inline std::vector<SphereState> out_of_overlap(const Grid& grid,
                                               std::span<const SphereState> spheres) {
  std::vector<SphereState> touching(spheres.begin(), spheres.end());
  for (SphereState& sphere : touching) {
    if (sphere.overlap.isZero(0.0)) continue;
    sphere.position = inside_the_box(grid, sphere.position - sphere.overlap);
    sphere.overlap.setZero();
  }
  return touching;
}

}  // namespace bedload
