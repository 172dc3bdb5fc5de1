#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// A number that belongs to the fluid (its time step, viscosity, ...) as the contact styles see it:
/// where a fix of style couple/fluid is present, the number that this fix holds, read anew each
/// time, else a constant from the script, else nothing.
class FluidValue {
 public:
  FluidValue() = default;

  /// Looks for `key` in the fix couple/fluid (Fix::extract), then for
  /// `fix ID all property/global <property> scalar <value>`, which ends the run with one sentence
  /// where it is not above 0 (a density may be 0). An empty name skips that place.
  static FluidValue find(LAMMPS_NS::LAMMPS* lmp, std::string_view key, std::string_view property);

  static FluidValue constant(double value);

  bool known() const { return live_ != nullptr || given_; }
  bool live() const { return live_ != nullptr; }
  double get() const { return live_ != nullptr ? *live_ : value_; }

 private:
  const double* live_ = nullptr;
  double value_ = 0;
  bool given_ = false;
};

/// Whether a number that the script states for use without a fluid is the fluid's.
inline bool same_as_fluid(double stated, double of_fluid) {
  return std::abs(stated - of_fluid) <= 1e-6 * std::abs(of_fluid);
}

/// λ of the fluid's step and loops (formulas/diffusion_number.hpp), which may change; the usual one
/// where step, viscosity, density or cell are not known.
class FluidDiffusion {
 public:
  static FluidDiffusion find(LAMMPS_NS::LAMMPS* lmp);
  double number() const;

 private:
  FluidValue viscosity_, density_, step_, cell_, loops_;
};

/// Length of a fluid time step [s]; ends the run with one sentence if nothing gives it. (What the
/// coupling gives may change from step to step.)
FluidValue require_fluid_time_step(LAMMPS_NS::LAMMPS* lmp, std::string_view style);

/// Dynamic viscosity [Pa s], from the coupling, the property fluidViscosity or a fix lubrication;
/// may be unknown (a dry scene).
FluidValue find_viscosity(LAMMPS_NS::LAMMPS* lmp);

/// An end of the fluid's box.
struct FluidEnd {
  enum class Kind { periodic, no_slip, free_slip } kind = Kind::periodic;
  std::array<double, 3> velocity{};  ///< of a no-slip wall, in its own plane [m/s]
};

/// The lower and the upper end of x, of y and of z. Empty without a fix couple/fluid.
std::span<const FluidEnd> find_fluid_ends(LAMMPS_NS::LAMMPS* lmp);

/// Density of the fluid [kg/m³], from the coupling or the property fluidDensity; 0 if unknown.
double find_fluid_density(LAMMPS_NS::LAMMPS* lmp);

}  // namespace bedload
