#include "coupling/start_spheres.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "fluid/errors.hpp"
#include "fluid/grid.hpp"
#include "fluid/spheres/sphere_bins.hpp"

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

}  // namespace

void check_start(const Settings& settings, std::span<const SphereState> spheres) {
  double widest = 0.0;
  for (const SphereState& sphere : spheres) widest = std::max(widest, 2.0 * sphere.radius);
  if (widest == 0.0) return;
  const Grid grid = make_grid(settings);
  SphereBins bins(grid, widest);
  for (std::size_t n = 0; n < spheres.size(); ++n)
    bins.insert(spheres[n].position, static_cast<int>(n));
  for (std::size_t n = 0; n < spheres.size(); ++n) {
    const SphereState& sphere = spheres[n];
    if (!sphere.mobile) continue;
    check_walls(settings, sphere);
    bins.near(sphere.position, widest, [&](int m) {
      const auto index = static_cast<std::size_t>(m);
      if (index == n) return;
      const SphereState& other = spheres[index];
      const double depth =
          sphere.radius + other.radius - shortest_way(grid, sphere.position, other.position).norm();
      if (depth > deepest * std::min(sphere.radius, other.radius))
        throw UserError(fmt::format(
            "atoms {} and {} of the LIGGGHTS script overlap by {:.3g} at the start, with the radii "
            "{} and {}; at most {} of the smaller radius is allowed.",
            sphere.tag, other.tag, depth, sphere.radius, other.radius, deepest));
    });
  }
}

}  // namespace bedload
