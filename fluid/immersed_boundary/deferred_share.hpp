#pragma once

namespace bedload {

/// Share of what the fluid owes a mobile sphere that it gets at a time.
///
/// The fluid answers a change du of the sphere's speed by the impulse -C rho_f V du, C the
/// coefficient of added mass, and that answer comes with the next load. A sphere that gets the
/// share s of what is owed changes what is still to come by the factor 1 - s (1 + C rho_f/rho_p).
/// With
///
///   s = rho_p/(rho_p + C* rho_f)
///
/// that is (C* - C)/(C* + rho_p/rho_f): no swing for C <= C*, whatever the density, and a kick ends
/// at rho_p/(rho_p + C rho_f) of its speed. A smaller share lets added mass arrive late, and a
/// collision of a few steps rebounds too slowly. C* = 2 covers what comes on top of the 1/2 of a
/// sphere alone: walls, neighbours, and the old pressure, which answers later. Trials: with forces
/// exchanged once a step C* = 1/2 and 1 leave swings of 5 and 2 % of the speed at a density ratio
/// of 1.2, 2 less than 1 % from 0.5 on; in each stage, C* = 1 leaves 3 % at 1.0 and 1.2.
inline double answered_share(double density, double fluid_density) {
  constexpr double largest_added_mass = 2.0;  // C*
  return density / (density + largest_added_mass * fluid_density);
}

/// Share of the deferred impulse (what changed inside a sphere between two forcings, added mass for
/// the most part) that it gets per stage.
/// @param setting spheres.deferred_impulse_share; 0: from the density
/// @param density of the sphere, 0: not known  @param fluid_density of the same unit [M/L^3]
inline double deferred_impulse_share(double setting, double density, double fluid_density) {
  constexpr double of_unknown_density = 0.1;  // slow, and stable from a ratio of 0.3 on
  if (setting > 0.0) return setting;
  return density > 0.0 ? answered_share(density, fluid_density) : of_unknown_density;
}

}  // namespace bedload
