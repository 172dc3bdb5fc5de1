#pragma once

#include "fluid/grid/sphere.hpp"

namespace bedload {

/// Another sphere, or an image of it, as it is seen from a mobile one.
struct SphereNeighbour {
  Vec3 way;            ///< from the mobile sphere's centre to its own [L]
  double radius;       ///< [L]
  bool first = false;  ///< has the points on the plane between both (DispersionCorrection)
  bool fixed = true;
  int index = 0;  ///< in the list of fixed, or of mobile spheres
};

}  // namespace bedload
