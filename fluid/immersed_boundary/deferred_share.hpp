#pragma once

#include <algorithm>

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
/// collision of a few steps rebounds too slowly. C* covers what comes on top of the 1/2 of a sphere
/// alone: walls, neighbours, the layer of a short step, and the old pressure, which answers later.
/// @param density of the sphere  @param fluid_density of the same unit [M/L^3]
/// @param largest_added_mass C*
inline double answered_share(double density, double fluid_density, double largest_added_mass) {
  return density / (density + largest_added_mass * fluid_density);
}

/// Share of the deferred impulse (what changed inside a sphere between two forcings, added mass for
/// the most part) that it gets per stage.
/// @param setting spheres.deferred_impulse_share; 0: from the density
/// @param density of the sphere, 0: not known  @param fluid_density of the same unit [M/L^3]
inline double deferred_impulse_share(double setting, double density, double fluid_density) {
  constexpr double of_unknown_density = 0.1;  // slow, and stable from a ratio of 0.3 on
  // Trials with steps of CFL 0.1 to 1: C* = 1 and 2 leave swings of up to 3 and 2 % of a kicked
  // sphere's speed at density ratios of 1.0 and 1.2, 4 less than 1 %.
  constexpr double largest_added_mass = 4.0;
  if (setting > 0.0) return setting;
  return density > 0.0 ? answered_share(density, fluid_density, largest_added_mass)
                       : of_unknown_density;
}

/// Share of the deferred angular impulse that a sphere gets per stage. Where the kernel alone
/// carries fluid along, alpha = 0.6 times as inert as that inside, half of it is stable from a
/// density ratio of 0.3 on: the spin's error changes by 1 - s (1 + alpha rho_f/rho_p). A long step
/// of implicit diffusion carries more fluid along: half swings and grows at ratios of 0.4 to 0.6
/// (nu dt/h^2 = 3.2), 0.2 does not. What comes late, on the other hand, makes heavy grains swing
/// that lie close to each other (marker_force.hpp): they get the whole.
/// @param setting spheres.deferred_angular_share; 0: chosen here
/// @param density of the sphere, 0: not known  @param fluid_density of the same unit [M/L^3]
inline double deferred_angular_share(double setting, double density, double fluid_density,
                                     bool implicit_diffusion) {
  constexpr double of_short_steps = 0.5, of_light = 0.45, of_unknown_density = 0.13;
  if (setting > 0.0) return setting;
  if (!implicit_diffusion) return of_short_steps;
  return density > 0.0 ? std::min(1.0, of_light * density / fluid_density) : of_unknown_density;
}

/// Share s of a stage's pressure correction that the old pressure takes over. The old pressure
/// holds the fluid's answer to the last change of a sphere's speed and acts in the next stage's
/// forcing, which changes it by 1 - s (1 + C rho_f/rho_p) from stage to stage. Between spheres half
/// a cell apart, each of which goes against its neighbours, C is 7: with a quarter that grows below
/// a density ratio of 1.1, with
///
///   s = 0.2 rho_p/rho_f
///
/// it dies away for C < 9. What the old pressure does not take over comes with the deferred
/// impulse, later: a sphere lighter than half the fluid swings by that for some stages after a
/// kick, and one that moves once a step does up to a ratio of 1. So a light one that is alone keeps
/// the quarter, and those that move once a step do (`./bedload study stability`, cases crowd,
/// density_ratio and density_ratio_step). Several light ones do not: a quarter makes groups of them
/// go wild with any step.
/// @param setting spheres.pressure_share; negative: chosen here
/// @param density of the lightest mobile sphere, 0: none is known
/// @param fluid_density of the same unit [M/L^3]  @param each_stage whether spheres move in it
/// @param several whether there is another mobile sphere
inline double old_pressure_share(double setting, double density, double fluid_density,
                                 bool each_stage, bool several) {
  constexpr double largest = 0.25, of_light = 0.2, lightest_alone = 0.5;
  if (setting >= 0.0) return setting;
  const double ratio = density / fluid_density;
  const bool for_neighbours = ratio >= lightest_alone || (several && ratio > 0.0);
  return each_stage && for_neighbours ? std::min(largest, of_light * ratio) : largest;
}

}  // namespace bedload
