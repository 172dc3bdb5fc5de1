#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fluid/grid/sphere_bins.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/validation/validate.hpp"

namespace bedload {
namespace {

/// Deepest overlap at the start, in radii of the smaller sphere.
constexpr double deepest = deepest_in_walls;
/// Density over the fluid's of the lightest mobile sphere that the scheme carries. A lighter one is
/// moved by its added mass more than by its own: the exchange of force and motion is unstable
/// (./bedload study stability --case density_ratio, --case density_ratio_step).
constexpr double lightest_in_stages = 0.3, lightest_in_steps = 0.5;
/// Numbers of two programs agree when they differ by less than this share of their size.
constexpr double tolerance = 1e-8;
/// Cells from a surface to the outermost point that its markers touch.
constexpr double support = 2.0;

/// Mobile spheres are atoms of a LIGGGHTS script; those of spheres.file are read line by line.
std::string name_of(const SphereState& sphere) {
  return fmt::format("atom {} of the LIGGGHTS script", sphere.tag);
}

/// Height that spheres may reach on a stretched grid [L].
double highest_place(const Grid& grid) {
  return std::max(grid.cubes_up_to() - support * grid.h, 0.0);
}

std::string above_the_cubes(const Grid& grid, const SphereState& sphere) {
  return fmt::format(
      "reaches up to y = {:.6g}, but y is stretched and spheres need cubic cells, which here means "
      "y below {:.6g}; change 'grid.y_uniform'",
      sphere.position.y() + sphere.radius, highest_place(grid));
}

bool is_above_the_cubes(const Grid& grid, const SphereState& sphere) {
  return grid.stretched() && sphere.position.y() + sphere.radius > highest_place(grid);
}

void check_density(const Settings& s, const SphereState& sphere) {
  const bool each_stage = s.coupling.exchange == Exchange::stage;
  const double limit = (each_stage ? lightest_in_stages : lightest_in_steps) * s.fluid.density;
  if (sphere.density == 0.0 || sphere.density >= limit * (1.0 - tolerance)) return;
  throw UserError(
      fmt::format("{} has density {}, but with 'coupling.exchange' = \"{}\" and 'fluid.density' = "
                  "{} the scheme "
                  "is stable only from {} on; set a density of at least that{}.",
                  name_of(sphere), sphere.density, each_stage ? "stage" : "step", s.fluid.density,
                  limit, each_stage ? "" : ", or exchange in each stage"));
}

void check_walls(const Grid& grid, const SphereState& sphere) {
  for (int d = 0; d < 3; ++d) {
    if (grid.periodic(d)) continue;
    const double length = grid.length[static_cast<std::size_t>(d)];
    const double below = sphere.radius - sphere.position[d];
    const double above = sphere.radius - (length - sphere.position[d]);
    if (std::max(below, above) > deepest * sphere.radius)
      throw UserError(fmt::format(
          "{} is at {} = {:.6g} with the radius {}, {:.3g} deep in the {} wall of the box [0, {}] "
          "(grid.length, boundary.{}); at most {} of a radius is allowed.",
          name_of(sphere), "xyz"[d], sphere.position[d], sphere.radius, std::max(below, above),
          below > above ? "lower" : "upper", length, "xyz"[d], deepest));
  }
}

void check_pair(const Grid& grid, const SphereState& a, const SphereState& b) {
  if (a.tag > b.tag) return check_pair(grid, b, a);
  const double depth = a.radius + b.radius - shortest_way(grid, a.position, b.position).norm();
  if (depth > deepest * std::min(a.radius, b.radius))
    throw UserError(fmt::format(
        "atoms {} and {} of the LIGGGHTS script overlap by {:.3g}, with the radii {} and {}; at "
        "most {} of the smaller radius is allowed.",
        a.tag, b.tag, depth, a.radius, b.radius, deepest));
}

/// The rules for those spheres for which `is_looked_at` holds, each by itself.
template <class Condition>
void check_each(const Settings& settings, const Grid& grid, std::span<const SphereState> spheres,
                Condition is_looked_at) {
  for (const SphereState& sphere : spheres) {
    if (!is_looked_at(sphere)) continue;
    if (const auto flaw = flaw_of(grid, sphere))
      throw UserError(fmt::format("{} {}.", name_of(sphere), *flaw));
    if (!sphere.mobile) continue;
    check_density(settings, sphere);
    check_walls(grid, sphere);
  }
}

/// The mobile ones among those, against their neighbours.
template <class Condition>
void check_pairs(const Grid& grid, std::span<const SphereState> spheres, Condition is_looked_at) {
  double widest = 0.0;
  for (const SphereState& sphere : spheres) widest = std::max(widest, 2.0 * sphere.radius);
  if (widest == 0.0) return;
  SphereBins bins(grid, widest);
  for (std::size_t n = 0; n < spheres.size(); ++n)
    bins.insert(spheres[n].position, static_cast<int>(n));
  for (std::size_t n = 0; n < spheres.size(); ++n)
    if (spheres[n].mobile && is_looked_at(spheres[n]))
      bins.near(spheres[n].position, widest, [&](int other) {
        const auto m = static_cast<std::size_t>(other);
        if (m != n) check_pair(grid, spheres[n], spheres[m]);
      });
}

}  // namespace

std::optional<std::string> flaw_of(const Grid& grid, const SphereState& sphere) {
  const double diameter = 2.0 * sphere.radius;
  if (!(diameter >= least_cells_per_diameter * grid.h))
    return fmt::format(
        "has the radius {}, and with cells of {} ('grid.length', 'grid.cells') is {:.3g} cells "
        "across, but at least {} cells are needed",
        sphere.radius, grid.h, diameter / grid.h, least_cells_per_diameter);
  for (int d = 0; d < 3; ++d) {
    const double length = grid.length[static_cast<std::size_t>(d)], x = sphere.position[d];
    if (grid.periodic(d) && diameter > length)
      return fmt::format(
          "has the diameter {}, but the box ('grid.length') is only {} long along {}, where it is "
          "periodic",
          diameter, length, "xyz"[d]);
    if (!grid.periodic(d) && (x < -sphere.radius || x > length + sphere.radius))
      return fmt::format("has {} = {}, but the box reaches from 0 to {}", "xyz"[d], x, length);
  }
  if (is_above_the_cubes(grid, sphere)) return above_the_cubes(grid, sphere);
  return std::nullopt;
}

void check_in_cubes(const std::string& file, const Grid& grid,
                    std::span<const SphereState> spheres) {
  if (!grid.stretched()) return;
  for (const SphereState& sphere : spheres)
    if (is_above_the_cubes(grid, sphere))
      throw UserError(
          fmt::format("{}: sphere {} {}.", file, sphere.tag, above_the_cubes(grid, sphere)));
}

void validate(const Settings& settings, std::span<const SphereState> spheres, Overlaps overlaps) {
  const Grid grid = make_grid(settings);
  const auto all = [](const SphereState&) { return true; };
  check_each(settings, grid, spheres, all);
  if (overlaps == Overlaps::slight) check_pairs(grid, spheres, all);
}

void validate(const Settings& settings, std::span<const SphereState> spheres,
              std::span<const std::int64_t> changed) {
  if (changed.empty()) return;
  const Grid grid = make_grid(settings);
  const auto has_changed = [changed](const SphereState& sphere) {
    return std::binary_search(changed.begin(), changed.end(), sphere.tag);
  };
  check_each(settings, grid, spheres, has_changed);
  check_pairs(grid, spheres, has_changed);
}

}  // namespace bedload
