#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"

namespace bedload {

/// Which points of a y plane lie inside spheres: one weight per point of a row, 0 inside and 1 in
/// the fluid. A point belongs to the solid when |x - x_p| < R, periodic images included.
class SolidRows {
 public:
  explicit SolidRows(const Grid& grid) : grid_(grid) {
    weight_.resize(static_cast<std::size_t>(grid.cells[0]));
    segments_.resize(static_cast<std::size_t>(grid.cells[2]));
  }

  /// Takes up the plane at height `y` whose points lie `offset` cells (0.5: centres, 1: upper
  /// faces) behind the lower face of their cell along x and z.
  void cut(std::span<const SphereState> spheres, double y, double offset_x, double offset_z) {
    for (std::vector<Segment>& row : segments_) row.clear();
    any_ = false;
    for (const SphereState& sphere : spheres) {
      const double dy = nearest_image(y - sphere.position[1], 1);
      const double disc = sphere.radius * sphere.radius - dy * dy;
      if (disc > 0.0) add_disc(sphere, disc, offset_x, offset_z);
    }
  }

  bool any() const { return any_; }
  /// Weights of the points i = 0 .. nx-1 of row k; nullptr: all of them lie in the fluid.
  const double* weights(int k) {
    const std::vector<Segment>& row = segments_[static_cast<std::size_t>(k)];
    if (row.empty()) return nullptr;
    std::fill(weight_.begin(), weight_.end(), 1.0);
    const int nx = grid_.cells[0];
    for (const Segment& segment : row)
      for (int i = segment.first; i <= segment.last; ++i) {
        const int wrapped = grid_.periodic(0) ? ((i % nx) + nx) % nx : i;
        if (wrapped >= 0 && wrapped < nx) weight_[static_cast<std::size_t>(wrapped)] = 0.0;
      }
    return weight_.data();
  }

 private:
  struct Segment {
    int first, last;
  };

  double nearest_image(double distance, int direction) const {
    if (!grid_.periodic(direction)) return distance;
    const double length = grid_.length[static_cast<std::size_t>(direction)];
    return distance - length * std::round(distance / length);
  }

  /// The points of a disc of squared radius `disc` about the sphere's centre.
  void add_disc(const SphereState& sphere, double disc, double offset_x, double offset_z) {
    const double h = grid_.h, reach = std::sqrt(disc);
    const int nz = grid_.cells[2];
    const auto first = static_cast<int>(std::ceil((sphere.position[2] - reach) / h - offset_z));
    const auto last = static_cast<int>(std::floor((sphere.position[2] + reach) / h - offset_z));
    for (int k = first; k <= last; ++k) {
      const int wrapped = grid_.periodic(2) ? ((k % nz) + nz) % nz : k;
      if (wrapped < 0 || wrapped >= nz) continue;
      const double dz = (k + offset_z) * h - sphere.position[2];
      const double half = disc - dz * dz;
      if (half <= 0.0) continue;
      const double chord = std::sqrt(half);
      const Segment segment{
          static_cast<int>(std::ceil((sphere.position[0] - chord) / h - offset_x)),
          static_cast<int>(std::floor((sphere.position[0] + chord) / h - offset_x))};
      if (segment.first > segment.last) continue;
      segments_[static_cast<std::size_t>(wrapped)].push_back(segment);
      any_ = true;
    }
  }

  const Grid& grid_;
  std::vector<double> weight_;
  std::vector<std::vector<Segment>> segments_;
  bool any_ = false;
};

}  // namespace bedload
