#include "coupling/start_spheres.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "fluid/errors.hpp"

namespace bedload {
namespace {

constexpr double deepest = 0.5;  // of the smaller radius

void check_walls(const Settings& s, const SphereState& sphere) {
  const std::array ends{s.boundary.x, s.boundary.y, s.boundary.z};
  for (int d = 0; d < 3; ++d) {
    const auto n = static_cast<std::size_t>(d);
    if (ends[n][0] == Wall::periodic) continue;
    const double below = sphere.radius - sphere.position[d];
    const double above = sphere.radius - (s.grid.length[n] - sphere.position[d]);
    if (std::max(below, above) > deepest * sphere.radius)
      throw UserError(fmt::format(
          "atom {} of the LIGGGHTS script starts at {} = {:.6g} with the radius {}, {:.3g} deep in "
          "the {} wall of the box [0, {}] (grid.length, boundary.{}); at most {} of a radius is "
          "allowed.",
          sphere.tag, "xyz"[d], sphere.position[d], sphere.radius, std::max(below, above),
          below > above ? "lower" : "upper", s.grid.length[n], "xyz"[d], deepest));
  }
}

/// Spheres by the bin that holds their centre; bins are at least as wide as the largest sphere.
class Bins {
 public:
  Bins(const Settings& s, std::span<const SphereState> spheres) : spheres_(spheres) {
    double widest = 0.0;
    for (const SphereState& sphere : spheres) widest = std::max(widest, 2.0 * sphere.radius);
    const std::array ends{s.boundary.x, s.boundary.y, s.boundary.z};
    for (std::size_t d = 0; d < 3; ++d) {
      length_[d] = s.grid.length[d];
      periodic_[d] = ends[d][0] == Wall::periodic;
      count_[d] = std::clamp<std::int64_t>(
          widest > 0.0 ? static_cast<std::int64_t>(length_[d] / widest) : 1, 1, 1 << 20);
    }
    for (std::size_t n = 0; n < spheres.size(); ++n)
      bins_[number(bin_of(spheres[n].position))].push_back(n);
  }

  /// Calls visit(other, distance of the centres) for every other sphere nearby, perhaps twice.
  template <class Visit>
  void near(std::size_t n, Visit&& visit) const {
    const auto here = bin_of(spheres_[n].position);
    for (std::int64_t i = -1; i <= 1; ++i)
      for (std::int64_t j = -1; j <= 1; ++j)
        for (std::int64_t k = -1; k <= 1; ++k) {
          const auto found = bins_.find(number({here[0] + i, here[1] + j, here[2] + k}));
          if (found == bins_.end()) continue;
          for (const std::size_t other : found->second)
            if (other != n) visit(spheres_[other], distance(spheres_[n], spheres_[other]));
        }
  }

 private:
  using Place = std::array<std::int64_t, 3>;
  Place bin_of(const Vec3& x) const {
    Place place{};
    for (std::size_t d = 0; d < 3; ++d)
      place[d] =
          std::clamp<std::int64_t>(static_cast<std::int64_t>(x[static_cast<int>(d)] / length_[d] *
                                                             static_cast<double>(count_[d])),
                                   0, count_[d] - 1);
    return place;
  }
  std::int64_t number(Place place) const {
    for (std::size_t d = 0; d < 3; ++d) {
      if (periodic_[d]) place[d] = (place[d] + count_[d]) % count_[d];
      if (place[d] < 0 || place[d] >= count_[d]) return -1;
    }
    return (place[0] * count_[1] + place[1]) * count_[2] + place[2];
  }
  double distance(const SphereState& a, const SphereState& b) const {
    Vec3 apart = a.position - b.position;
    for (int d = 0; d < 3; ++d) {
      const double length = length_[static_cast<std::size_t>(d)];
      if (periodic_[static_cast<std::size_t>(d)])
        apart[d] -= length * std::round(apart[d] / length);
    }
    return apart.norm();
  }

  std::span<const SphereState> spheres_;
  std::array<double, 3> length_{};
  std::array<bool, 3> periodic_{};
  Place count_{};
  std::unordered_map<std::int64_t, std::vector<std::size_t>> bins_;
};

}  // namespace

void check_start(const Settings& settings, std::span<const SphereState> spheres) {
  const Bins bins(settings, spheres);
  for (std::size_t n = 0; n < spheres.size(); ++n) {
    const SphereState& sphere = spheres[n];
    if (!sphere.mobile) continue;
    check_walls(settings, sphere);
    bins.near(n, [&](const SphereState& other, double distance) {
      const double depth = sphere.radius + other.radius - distance;
      if (depth > deepest * std::min(sphere.radius, other.radius))
        throw UserError(fmt::format(
            "atoms {} and {} of the LIGGGHTS script overlap by {:.3g} at the start, with the radii "
            "{} and {}; at most {} of the smaller radius is allowed.",
            sphere.tag, other.tag, depth, sphere.radius, other.radius, deepest));
    });
  }
}

}  // namespace bedload
