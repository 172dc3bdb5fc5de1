#pragma once

#include <cmath>
#include <numbers>

namespace bedload::contact {

/// Time that a Rayleigh wave takes along half of a sphere's circumference [s],
///
///   T_R = π R √(ρ/G) / (0.1631 ν + 0.8766),   G = Y/(2 (1 + ν)),
///
/// of which a step of a contact with the material's own stiffness may be a part only (Ning and
/// Thornton, Powders & Grains 93 (1993); the same as LIGGGHTS' fix check/timestep/gran).
/// @param radius [m], density [kg/m³], youngs_modulus [Pa]
inline double rayleigh_time(double radius, double density, double youngs_modulus,
                            double poissons_ratio) {
  const double shear_modulus = youngs_modulus / (2.0 * (1.0 + poissons_ratio));
  return std::numbers::pi * radius * std::sqrt(density / shear_modulus) /
         (0.1631 * poissons_ratio + 0.8766);
}

}  // namespace bedload::contact
