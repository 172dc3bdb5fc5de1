#include "liggghts_styles/fluid_values.hpp"

#include <fmt/format.h>

#include <string>

#include "fix_property_global.h"
#include "lammps.h"
#include "liggghts_styles/formulas/diffusion_number.hpp"
#include "liggghts_styles/impulse_on_walls.hpp"
#include "liggghts_styles/keywords.hpp"
#include "modify.h"

namespace bedload {

namespace {

template <class Value = double>
Value* extract(LAMMPS_NS::LAMMPS* lmp, const char* style, std::string_view key) {
  LAMMPS_NS::Fix* fix = lmp->modify->find_fix_style_strict(style, 0);
  int dimension = 0;
  return fix == nullptr ? nullptr
                        : static_cast<Value*>(fix->extract(std::string(key).c_str(), dimension));
}

/// What a script says of its fluid [value of `property`]: above 0, a density of 0 means none.
double checked(LAMMPS_NS::LAMMPS* lmp, const std::string& property, double value) {
  const bool density = property == "fluidDensity";
  if (value > 0 || (density && value == 0)) return value;
  stop_run(lmp, fmt::format("property/global {} has to be {} 0, found {:g}", property,
                            density ? "at least" : "more than", value));
}

}  // namespace

FluidValue FluidValue::constant(double value) {
  FluidValue v;
  v.value_ = value;
  v.given_ = true;
  return v;
}

FluidValue FluidValue::find(LAMMPS_NS::LAMMPS* lmp, std::string_view key,
                            std::string_view property) {
  FluidValue v;
  if (!key.empty()) v.live_ = extract(lmp, "couple/fluid", key);
  if (v.live_ != nullptr || property.empty()) return v;
  const std::string name(property);
  auto* fix = static_cast<LAMMPS_NS::FixPropertyGlobal*>(lmp->modify->find_fix_property(
      name.c_str(), "property/global", "scalar", 0, 0, "bedload", false));
  return fix == nullptr ? v : constant(checked(lmp, name, fix->compute_scalar()));
}

FluidDiffusion FluidDiffusion::find(LAMMPS_NS::LAMMPS* lmp) {
  FluidDiffusion of_fluid;
  of_fluid.viscosity_ = FluidValue::find(lmp, "viscosity", "fluidViscosity");
  of_fluid.density_ = FluidValue::find(lmp, "fluid_density", "fluidDensity");
  of_fluid.step_ = FluidValue::find(lmp, "dt_fluid", "fluidTimeStep");
  of_fluid.cell_ = FluidValue::find(lmp, "cell_size", "fluidCellSize");
  of_fluid.loops_ = FluidValue::find(lmp, "forcing_loops", "");
  return of_fluid;
}

double FluidDiffusion::number() const {
  const bool known = viscosity_.known() && density_.known() && step_.known() && cell_.known();
  if (!known || !(density_.get() > 0)) return contact::usual_diffusion_number;
  const double h = cell_.get(), loops = loops_.known() ? loops_.get() : 1;
  return contact::diffusion_number_of_loop(
      viscosity_.get() / density_.get() * step_.get() / (h * h), loops);
}

FluidValue require_fluid_time_step(LAMMPS_NS::LAMMPS* lmp, std::string_view style) {
  const FluidValue dt = FluidValue::find(lmp, "dt_fluid", "fluidTimeStep");
  if (!dt.known()) {
    stop_run(lmp,
             fmt::format("{} needs the fluid time step: add a fix couple/fluid, or without a "
                         "fluid the line 'fix ID all property/global fluidTimeStep scalar <s>'",
                         style));
  }
  return dt;
}

FluidValue find_viscosity(LAMMPS_NS::LAMMPS* lmp) {
  const FluidValue v = FluidValue::find(lmp, "viscosity", "fluidViscosity");
  if (v.known()) return v;
  const double* of_fix = extract(lmp, "lubrication", "viscosity");
  return of_fix == nullptr ? v : FluidValue::constant(*of_fix);
}

std::span<const FluidEnd> find_fluid_ends(LAMMPS_NS::LAMMPS* lmp) {
  const auto* ends = extract<FluidEnd>(lmp, "couple/fluid", "ends");
  return ends == nullptr ? std::span<const FluidEnd>{} : std::span<const FluidEnd>(ends, 6);
}

ImpulseOnWalls* find_impulse_on_walls(LAMMPS_NS::LAMMPS* lmp) {
  return extract<ImpulseOnWalls>(lmp, "couple/fluid", "impulse_on_walls");
}

double find_fluid_density(LAMMPS_NS::LAMMPS* lmp) {
  const FluidValue v = FluidValue::find(lmp, "fluid_density", "fluidDensity");
  return v.known() ? v.get() : 0.0;
}

}  // namespace bedload
