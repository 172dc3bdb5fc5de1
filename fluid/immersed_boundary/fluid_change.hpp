#pragma once

#include "fluid/grid/sphere.hpp"

namespace bedload {

/// What the fluid's cells have got from a sphere, velocity times cells, and its moment about the
/// sphere's centre [L].
struct FluidChange {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();

  FluidChange& operator+=(const FluidChange& more) {
    linear += more.linear;
    angular += more.angular;
    return *this;
  }
  /// `change` of component c, whose places from the centre, times the change, add up to `moment`.
  void add(int c, double change, const Vec3& moment) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    linear[c] += change;
    angular[a] += moment[b];  // (r cross f)_a = r_b f_c - r_c f_b
    angular[b] -= moment[a];  // (r cross f)_b = r_c f_a - r_a f_c
  }
};

}  // namespace bedload
