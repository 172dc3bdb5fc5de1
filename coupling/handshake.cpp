#include "coupling/handshake.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "coupling/stages.hpp"

namespace bedload {
namespace {

constexpr double tolerance = 1e-8;
constexpr double least_cells_per_diameter = 4.0;
/// Density over the fluid's of the lightest sphere that the scheme carries.
constexpr double lightest_in_stages = 0.3, lightest_in_steps = 1.2;
/// The same of the lightest that does not swing with one exchange per step.
constexpr double quiet_in_steps = 2.5;
/// Ratio of masses from which on a contact is entered deeper than it should be: 3 is well, 8 is not
/// (the cases pinned and size_ratio of the study of stability).
constexpr double masses_apart = 8.0;
constexpr std::array<std::string_view, 3> axis{"x", "y", "z"};

bool agree(double a, double b, double size) { return std::abs(a - b) <= tolerance * size; }

double size_of(const Triple& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

std::string text(const Triple& a) { return fmt::format("({}, {}, {})", a[0], a[1], a[2]); }

std::string_view text(bool periodic) { return periodic ? "periodic" : "not periodic"; }

std::optional<std::string> box_disagreement(const FluidFacts& fluid, const DemFacts& dem) {
  for (std::size_t d = 0; d < 3; ++d) {
    if ((fluid.periodic[d] != 0) != (dem.periodic[d] != 0))
      return fmt::format(
          "{} is {} in fluid.toml (boundary.{}) but {} in the LIGGGHTS script (boundary).", axis[d],
          text(fluid.periodic[d] != 0), axis[d], text(dem.periodic[d] != 0));
    if (!agree(dem.box_low[d], 0.0, fluid.length[d]) ||
        !agree(dem.box_high[d], fluid.length[d], fluid.length[d]))
      return fmt::format(
          "the box along {} is [0, {}] in fluid.toml (grid.length) but [{}, {}] in the LIGGGHTS "
          "script (create_box).",
          axis[d], fluid.length[d], dem.box_low[d], dem.box_high[d]);
  }
  return std::nullopt;
}

std::optional<std::string> gravity_disagreement(const FluidFacts& fluid, const DemFacts& dem) {
  const double size = std::max(size_of(fluid.gravity), size_of(dem.gravity));
  for (std::size_t d = 0; d < 3; ++d)
    if (!agree(fluid.gravity[d], dem.gravity[d], size))
      return dem.has_gravity != 0
                 ? fmt::format(
                       "gravity is {} in fluid.toml (fluid.gravity) but {} in the LIGGGHTS script "
                       "(fix gravity).",
                       text(fluid.gravity), text(dem.gravity))
                 : fmt::format(
                       "gravity is {} in fluid.toml (fluid.gravity) but the LIGGGHTS script has no "
                       "fix gravity.",
                       text(fluid.gravity));
  return std::nullopt;
}

std::optional<std::string> material_disagreement(const FluidFacts& fluid, const DemFacts& dem) {
  if (!std::isnan(dem.density) && !agree(fluid.density, dem.density, fluid.density))
    return fmt::format(
        "the fluid's density is {} in fluid.toml (fluid.density) but {} in the LIGGGHTS script "
        "(property fluidDensity).",
        fluid.density, dem.density);
  const double viscosity = fluid.density * fluid.kinematic_viscosity;
  if (!std::isnan(dem.viscosity) && !agree(viscosity, dem.viscosity, viscosity))
    return fmt::format(
        "the dynamic viscosity is {} in fluid.toml (fluid.density times fluid.kinematic_viscosity) "
        "but {} in the LIGGGHTS script (property fluidViscosity).",
        viscosity, dem.viscosity);
  return std::nullopt;
}

std::optional<std::string> sphere_disagreement(const FluidFacts& fluid, const DemFacts& dem) {
  if (dem.mobile + dem.fixed == 0)
    return "the group of fix couple/fluid holds no atom, so there is nothing to couple; create the "
           "atoms before coupled_run, or run bedload-fluid alone.";
  const double across = 2.0 * dem.smallest_radius / fluid.cell_size;
  if (across < least_cells_per_diameter)
    return fmt::format(
        "the smallest sphere in the LIGGGHTS script has diameter {}, which is {:.3g} cells of {} "
        "in "
        "fluid.toml (grid.cells, grid.length); at least {} are needed.",
        2.0 * dem.smallest_radius, across, fluid.cell_size, least_cells_per_diameter);
  for (std::size_t d = 0; d < 3; ++d)
    if (2.0 * dem.largest_radius > fluid.length[d])
      return fmt::format(
          "the largest sphere in the LIGGGHTS script has diameter {}, but the box in fluid.toml "
          "(grid.length) is only {} long along {}.",
          2.0 * dem.largest_radius, fluid.length[d], axis[d]);
  return std::nullopt;
}

/// A lighter sphere is moved by its added mass more than by its own: the exchange of force and
/// motion swings up (./bedload study stability --case density_ratio, --case density_ratio_step).
std::optional<std::string> too_light(const FluidFacts& fluid, const DemFacts& dem) {
  const bool each_stage = DemSteps{fluid.dem_steps}.exchange_in(0);
  const double limit = (each_stage ? lightest_in_stages : lightest_in_steps) * fluid.density;
  if (dem.mobile == 0 || dem.smallest_density >= limit * (1.0 - tolerance)) return std::nullopt;
  return fmt::format(
      "the lightest mobile sphere in the LIGGGHTS script has density {}, but with "
      "'coupling.exchange' = \"{}\" and 'fluid.density' = {} the scheme is stable only from {} on; "
      "set a density of at least that{}.",
      dem.smallest_density, each_stage ? "stage" : "step", fluid.density, limit,
      each_stage ? "" : ", or exchange in each stage");
}

// Film at its smallest gap, 6 pi mu R^2 / (3e-3 R m), against the swing of an enduring contact
// whose overlap under the weight is 1e-3 R: the film ends at the contact, so what it would damp
// goes on.
std::optional<std::string> viscous_caution(const FluidFacts& fluid, const DemFacts& dem) {
  const double r = dem.smallest_radius, ratio = dem.smallest_density / fluid.density;
  const double film = 1500.0 * fluid.kinematic_viscosity / (ratio * r * r);
  const double submerged = size_of(fluid.gravity) * std::abs(ratio - 1.0) / ratio;
  const double swing = std::sqrt(submerged / (1e-3 * r));
  if (submerged == 0.0 || film <= 2.0 * swing) return std::nullopt;
  return fmt::format(
      "the fluid is so viscous that a grain pressed on a wall or a bed should creep into "
      "contact, but it swings there by some 0.1 % of its diameter for a while (./bedload study "
      "stability --case pressed); lower 'fluid.kinematic_viscosity' to {:.2g} where that matters.",
      2.0 * swing * ratio * r * r / 1500.0);
}

/// A contact of actm is as stiff as its own two spheres ask for, whatever leans on them.
std::optional<std::string> mass_caution(const FluidFacts&, const DemFacts& dem) {
  const double ratio = dem.heaviest / dem.lightest;
  if (ratio < masses_apart) return std::nullopt;
  return fmt::format(
      "the heaviest mobile sphere has {:.3g} times the mass of the lightest; one that gets between "
      "such a sphere and a wall or the bed is entered up to four times as deep as in a collision "
      "of "
      "equals (./bedload study stability --case pinned, --case size_ratio); reduce 'time.step' "
      "where "
      "that matters, to which the depth is proportional.",
      ratio);
}

std::optional<std::string> exchange_caution(const FluidFacts& fluid, const DemFacts& dem) {
  const bool each_stage = DemSteps{fluid.dem_steps}.exchange_in(0);
  if (each_stage || dem.smallest_density >= quiet_in_steps * fluid.density) return std::nullopt;
  return fmt::format(
      "with 'coupling.exchange' = \"step\" spheres lighter than {} of the fluid's density swing by "
      "some per cent of their speed, and the lightest here has {:.3g} (./bedload study stability "
      "--case density_ratio_step); set \"stage\" where that matters.",
      quiet_in_steps, dem.smallest_density / fluid.density);
}

}  // namespace

std::vector<std::string> cautions(const FluidFacts& fluid, const DemFacts& dem) {
  std::vector<std::string> sentences;
  if (dem.mobile == 0) return sentences;
  for (const auto& look : {viscous_caution, mass_caution, exchange_caution})
    if (auto sentence = look(fluid, dem)) sentences.push_back("caution: " + *sentence);
  return sentences;
}

std::optional<std::string> disagreement(const FluidFacts& fluid, const DemFacts& dem) {
  if (dem.force_factor != 1.0)
    return fmt::format(
        "force is mass times acceleration in the fluid but {} times that in the LIGGGHTS script "
        "(units); use units si, or lj for a scene without dimensions.",
        1.0 / dem.force_factor);
  for (const auto& check : {box_disagreement, gravity_disagreement, material_disagreement,
                            sphere_disagreement, too_light})
    if (auto sentence = check(fluid, dem)) return sentence;
  return std::nullopt;
}

}  // namespace bedload
