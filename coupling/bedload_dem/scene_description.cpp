#include "coupling/bedload_dem/scene_description.hpp"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <string_view>

#include "atom.h"
#include "coupling/bedload_dem/coupled_spheres.hpp"
#include "coupling/bedload_dem/over_ranks.hpp"
#include "coupling/bedload_dem/script_gravity.hpp"
#include "coupling/bedload_dem/script_rules.hpp"
#include "domain.h"
#include "force.h"
#include "lammps.h"
#include "liggghts_styles/fix_lubrication.hpp"
#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/mobility.hpp"
#include "modify.h"
#include "pair.h"
#include "pair_gran.h"

namespace bedload {
namespace {

/// pair_style and, for granular contacts, the models in it that have a name here.
std::string describe_contacts(LAMMPS_NS::Force& force) {
  std::string text = fmt::format("pair_style {}", force.pair_style);
  if (std::string_view(force.pair_style) != "gran") return text;
  auto& pair = static_cast<LAMMPS_NS::PairGran&>(*force.pair);
  constexpr std::array<std::array<const char*, 3>, 8> models{
      {{"normal", "model", "actm"},
       {"normal", "model", "rpm"},
       {"normal", "model", "hertz"},
       {"normal", "model", "hooke"},
       {"tangential", "tangential", "haff_werner"},
       {"tangential", "tangential", "history"},
       {"tangential", "tangential", "no_history"},
       {"cohesion", "cohesion", "sjkr"}}};
  for (const auto& [kind, keyword, name] : models)
    if (pair.contact_match(kind, name)) text += fmt::format(" {} {}", keyword, name);
  return text;
}

/// What the script states; NaN: nothing.
double stated(LAMMPS_NS::LAMMPS* lmp, std::string_view property) {
  const FluidValue value = FluidValue::find(lmp, "", property);
  return value.known() ? value.get() : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Box box_of(const LAMMPS_NS::Domain& domain) {
  return {triple(domain.boxlo),
          triple(domain.boxhi),
          {domain.periodicity[0], domain.periodicity[1], domain.periodicity[2]}};
}

DemSceneInfo describe_box(const Box& box) {
  DemSceneInfo scene{};
  scene.box_low = box.low;
  scene.box_high = box.high;
  scene.periodic = box.periodic;
  return scene;
}

DemSceneInfo describe_scene(LAMMPS_NS::LAMMPS* lmp, const CoupledSpheres& spheres, Moment moment) {
  const LAMMPS_NS::Atom& atom = *lmp->atom;
  DemSceneInfo scene = describe_box(box_of(*lmp->domain));
  const Mobility mobility(lmp);
  const ScriptGravity gravity = script_gravity(
      lmp, [&](int i) { return spheres.is_mobile(atom.mask[i]) && !mobility.held(atom.mask[i]); },
      moment);
  if (gravity.other)
    stop_run(lmp, fmt::format("fix couple/fluid: atom {} has another gravity than other mobile "
                              "spheres; put all of them in the group of 'fix gravity'",
                              *gravity.other));
  scene.has_gravity = gravity.stated ? 1 : 0;
  scene.gravity = gravity.value;
  scene.force_factor = lmp->force->ftm2v;
  for (int i = 0; i < atom.nlocal; ++i)
    if (spheres.contains(atom.mask[i]))
      ++(spheres.is_mobile(atom.mask[i]) ? scene.mobile : scene.fixed);
  scene.mobile = reduced(scene.mobile, MPI_INT64_T, MPI_SUM, lmp->world);
  scene.fixed = reduced(scene.fixed, MPI_INT64_T, MPI_SUM, lmp->world);
  scene.inserts = inserting_fixes(lmp);
  // A script may state the fluid's values for use without a fluid; then they have to be the same.
  scene.density = stated(lmp, "fluidDensity");
  scene.viscosity = stated(lmp, "fluidViscosity");
  return scene;
}

std::string describe_effects(LAMMPS_NS::LAMMPS* lmp) {
  const bool contacts = lmp->force->pair != nullptr;
  const auto* film =
      dynamic_cast<const FixLubrication*>(lmp->modify->find_fix_style_strict("lubrication", 0));
  const std::string left =
      contacts ? "; what markers leave acts" : "; what markers leave acts at walls alone";
  const auto line = [](const char* effect, bool on, const std::string& why) {
    return fmt::format("{}\t{}\t{}\n", effect, on ? "on" : "off", why);
  };
  return line("collisions", contacts,
              contacts ? describe_contacts(*lmp->force) : "the LIGGGHTS script has no pair_style") +
         line("lubrication", film != nullptr,
              film != nullptr
                  ? "fix lubrication"
                  : "the LIGGGHTS script has no fix lubrication; the grid alone lacks most of a "
                    "film much thinner than h/3") +
         line("films against sliding and rolling", film != nullptr && film->tangential(),
              film == nullptr      ? "no fix lubrication" + left
              : film->tangential() ? "fix lubrication, tangential on"
                                   : "fix lubrication, tangential off or law published" + left);
}

}  // namespace bedload
