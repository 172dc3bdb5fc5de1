#include "coupling/exchange/handshake.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace bedload {
namespace {

constexpr double tolerance = 1e-8;
constexpr std::array<std::string_view, 3> axis{"x", "y", "z"};

bool agree(double a, double b, double size) { return std::abs(a - b) <= tolerance * size; }

double size_of(const Triple& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

std::string text(const Triple& a) { return fmt::format("({}, {}, {})", a[0], a[1], a[2]); }

std::string_view text(bool periodic) { return periodic ? "periodic" : "not periodic"; }

std::optional<std::string> gravity_disagreement(const FluidSceneInfo& fluid,
                                                const DemSceneInfo& dem) {
  const double size = std::max(size_of(fluid.gravity), size_of(dem.gravity));
  for (std::size_t d = 0; d < 3; ++d)
    if (!agree(fluid.gravity[d], dem.gravity[d], size))
      return dem.has_gravity != 0
                 ? fmt::format(
                       "gravity is {} in fluid.toml (fluid.gravity) but {} in the LIGGGHTS script "
                       "(fix gravity and its group).",
                       text(fluid.gravity), text(dem.gravity))
                 : fmt::format(
                       "gravity is {} in fluid.toml (fluid.gravity) but the LIGGGHTS script has no "
                       "fix gravity.",
                       text(fluid.gravity));
  return std::nullopt;
}

std::optional<std::string> material_disagreement(const FluidSceneInfo& fluid,
                                                 const DemSceneInfo& dem) {
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

}  // namespace

std::optional<std::string> box_disagreement(const FluidSceneInfo& fluid, const DemSceneInfo& dem) {
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

std::optional<std::string> disagreement(const FluidSceneInfo& fluid, const DemSceneInfo& dem) {
  if (dem.force_factor != 1.0)
    return fmt::format(
        "force is mass times acceleration in the fluid but {} times that in the LIGGGHTS script "
        "(units); use units si, or lj for a scene without dimensions.",
        1.0 / dem.force_factor);
  for (const auto& check : {box_disagreement, gravity_disagreement, material_disagreement})
    if (auto sentence = check(fluid, dem)) return sentence;
  if (dem.mobile + dem.fixed + dem.inserts == 0)
    return "the group of fix couple/fluid holds no atom and no fix inserts any, so there is "
           "nothing to couple; create the atoms before coupled_run, or run bedload-fluid alone.";
  return std::nullopt;
}

}  // namespace bedload
