#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "fluid/grid/sphere.hpp"

// How far the markers of one sphere are from the surfaces of others.

namespace bedload {

/// An end of the box that is not periodic.
struct BoxEnd {
  int direction;
  double inwards;   ///< 1 at the lower end of the box, -1 at the upper one
  double position;  ///< [L]
  bool free_slip;   ///< else no-slip

  /// Of a point over it [L].
  double height_of(const Vec3& point) const { return inwards * (point[direction] - position); }
};

/// Distances of one sphere's markers, by offset, from the nearest two surfaces of others [L].
struct Nearest {
  std::vector<double> first, second;

  void reset(std::size_t markers, double reach) {
    first.assign(markers, reach);
    second.assign(markers, reach);
  }
  /// A sphere of `radius`, seen from whose centre the markers lie at `way` + offset.
  void take_sphere(const std::array<std::vector<double>, 3>& offsets, const Vec3& way,
                   double radius) {
    for (std::size_t m = 0; m < first.size(); ++m) {
      const double x = way.x() + offsets[0][m], y = way.y() + offsets[1][m],
                   z = way.z() + offsets[2][m];
      take(m, std::sqrt(x * x + y * y + z * z) - radius);
    }
  }
  /// A plane, over which the centre is at `height`; `inwards` is the sign of its normal along the
  /// direction of the offsets.
  void take_plane(const std::vector<double>& offsets, double height, double inwards) {
    for (std::size_t m = 0; m < first.size(); ++m) take(m, height + inwards * offsets[m]);
  }

 private:
  void take(std::size_t m, double distance) {
    second[m] = std::min(second[m], std::max(first[m], distance));
    first[m] = std::min(first[m], distance);
  }
};

/// Those beside one mobile sphere: of spheres that can move, itself behind periodic and free-slip
/// ends among them, and of what cannot, the bed and no-slip ends.
class SurfacesBeside {
 public:
  /// Surfaces up to `far` from the sphere's own [L] count, if any is within `reach`.
  SurfacesBeside(double reach, double far) : reach_(reach), far_(far) {}

  /// The sphere whose surfaces beside it are added from here on.
  void begin(const SphereState& sphere) {
    sphere_ = &sphere;
    mobile_.clear();
    bed_.clear();
    ends_.clear();
    any_ = false;
  }

  /// A sphere of `radius` that can move, or of the bed; `way` from its centre to the sphere's.
  void add_mobile(const Vec3& way, double radius) { add(mobile_, way, radius); }
  void add_bed(const Vec3& way, double radius) { add(bed_, way, radius); }

  /// An end of the box. A free-slip one is the plane of symmetry between the sphere and its image.
  void add(const BoxEnd& end) {
    const double height = end.height_of(sphere_->position);
    if (end.free_slip && 2.0 * height < 2.0 * sphere_->radius + far_)
      add_mobile(2.0 * end.inwards * height * Vec3::Unit(end.direction), sphere_->radius);
    if (!end.free_slip && height < sphere_->radius + far_) {
      ends_.push_back(&end);
      any_ |= height < sphere_->radius + reach_;
    }
  }

  /// Whether a surface is within reach.
  bool any() const { return any_; }

  /// Distances of all markers, whose offsets from the centre are `along` x, y and z.
  void measure(const std::array<std::vector<double>, 3>& along) {
    movable_.reset(along[0].size(), far_);
    fixed_.reset(along[0].size(), far_);
    for (const Other& other : mobile_) movable_.take_sphere(along, other.way, other.radius);
    for (const Other& other : bed_) fixed_.take_sphere(along, other.way, other.radius);
    for (const BoxEnd* end : ends_)
      fixed_.take_plane(along[static_cast<std::size_t>(end->direction)],
                        end->height_of(sphere_->position), end->inwards);
  }

  /// Of marker m from the nearest surface, and from the next one where one of both can move [L]:
  /// pores of fixed spheres and walls alone are none here, as films are measured there (README.md,
  /// "Surfaces in the same cells").
  std::array<double, 2> film_and_pore(std::size_t m) const {
    if (fixed_.first[m] < movable_.first[m]) return {fixed_.first[m], movable_.first[m]};
    return {movable_.first[m], std::min(movable_.second[m], fixed_.first[m])};
  }

 private:
  struct Other {
    Vec3 way;
    double radius;
  };

  void add(std::vector<Other>& all, const Vec3& way, double radius) {
    all.push_back({way, radius});
    any_ |= way.norm() < sphere_->radius + radius + reach_;
  }

  double reach_, far_;
  const SphereState* sphere_ = nullptr;
  std::vector<Other> mobile_, bed_;
  std::vector<const BoxEnd*> ends_;
  bool any_ = false;
  Nearest movable_, fixed_;
};

}  // namespace bedload
