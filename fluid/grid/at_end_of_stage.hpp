#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/grid/sphere_bins.hpp"

namespace bedload {

/// The spheres where the forcing of a stage finds them at its end [L], inside the periodic box:
/// where they only touch, at position - overlap, and from there on their way for `time` [T], the
/// stage's length. The stage forces velocities at its end; markers that stood where the spheres
/// were at its begin would lag by u dt, an error of first order in the step. A sphere in a
/// collision goes no further into what it touches, and none further than a cell.
inline std::vector<SphereState> at_end_of_stage(const Grid& grid,
                                                std::span<const SphereState> spheres, double time) {
  std::vector<SphereState> there(spheres.begin(), spheres.end());
  for (SphereState& sphere : there) {
    Vec3 way = time * sphere.velocity;
    way *= grid.h / std::max(way.norm(), grid.h);
    if (!sphere.overlap.isZero(0.0)) {
      const Vec3 inwards = sphere.overlap.normalized();
      way -= inwards.dot(way) * inwards + sphere.overlap;
    }
    if (way.isZero(0.0)) continue;
    sphere.position = inside_the_box(grid, sphere.position + way);
    sphere.overlap.setZero();
  }
  return there;
}

}  // namespace bedload
