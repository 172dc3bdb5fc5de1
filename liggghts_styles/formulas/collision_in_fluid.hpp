#pragma once

#include <algorithm>
#include <cmath>

/// What becomes of the fluid's load in a collision that is stretched to T_c.
///
/// A real collision takes microseconds: the fluid neither turns nor squeezes while it lasts. In one
/// stretched to some fluid steps it does, late. So the contact bears what the relative acceleration
/// A of the two surfaces by the fluid's loads has changed by since the touch,
///     F = -w m (A - A_0),   A = n·(L_i/m_i - L_j/m_j),   A_0 = max(0, A at the touch),
/// equal and opposite on both. Weight and the drag that parts them act on: a constant load does no
/// work in a contact that ends where it began. A load that pushes them together is borne: at the
/// touch it is the answer to the film's last push, and would draw the collision out. In exchange a
/// damper takes what viscosity would have taken. A sphere that nothing but Basset's force couples
/// to the fluid keeps exp(τ) erfc(√τ) of a jump Δu of its speed; so it loses, with its added mass,
/// as the contact turns that round, too,
///     β Δu,   β = 1 - exp(τ) erfc(√τ),   √τ = 6 π R² ρf sqrt(ν t)/(m + (2/3) π R³ ρf).
/// t is the time for which the contact pays, because the run's fluid does not: while the layer
/// grows in the stretched collision, and while it is thinner than the grid tells,
///     t = a (T_c/2 + h²/(5 ν))/4 + (1 - a) κ (0.3 T_c + 2.3 h/u),
///     κ = 2.1 ((m + m_a)/(m + 7 m_a))² (R_eff/R)^{1/2},   m_a = (2/3) π R³ ρf.
/// a = 1: the layer is thicker than the kernel, whose width adds to it, and half of the impulse (a
/// quarter of the time) comes later all the same, in flight. a = 0: it is thinner, and the grid
/// knows of none until the sphere has left the reach of its kernel. A steel sphere (density ratio
/// 8.3: κ = 1.2 at a wall) keeps its speed meanwhile; a light one (1.25: κ = 0.28) has lost much of
/// it by then, and a jump that does not last leaves no impulse to pay; the kernel of one that meets
/// another sphere is left sooner than that of one on a wall. There the fluid takes a part by
/// itself, too, as its answer to the turn comes some steps late, when the collision is over and
/// nobody bears it: of the mass that turns m_a/(m + m_a), for some steps of T_c,
///     ε = 1.8 m_a/(m + m_a) Δt/T_c (R_eff/R)^{1/2},
/// and the contact pays β - (1 - a) ε, or nothing. Rebounds at St = 27 (a = 1, D/h =
/// 6 to 16) and 152 (a = 0), in collisions of five, ten and twenty steps, ask for the other
/// numbers, those of κ the rebounds of light spheres on grids up to 40 cells to a diameter.
///
/// Symbols: L load of the fluid [N]; m_i, m_j masses, m the reduced one [kg]; w weight [-]; u speed
/// at the touch [m/s]; St = ρp u D/(9 μ) of the heavier partner; h cell size [m]; R_eff that
/// of the film, R at a wall [m].
namespace bedload::contact {

/// w: 0 up to St = 5, where a contact is an enduring one by default (at St = 5 at the touch the
/// film has taken as much again, and nothing rebounds below), 1 from 10 on.
inline double collision_weight(double stokes) { return std::clamp((stokes - 5) / 5, 0.0, 1.0); }

/// a: when the sphere has moved by a cell, its layer is as thick as sqrt(ν h/u) = h/sqrt(Re_h);
/// 1 up to Re_h = u h/ν = 6, 0 from 11 on.
inline double resolved_layer(double cell_reynolds) {
  return std::clamp((11 - cell_reynolds) / 5, 0.0, 1.0);
}

/// m_a [kg]: half of the displaced fluid's.
inline double added_mass(double radius, double fluid_density) {
  constexpr double pi = 3.14159265358979323846;
  return 2 * pi / 3 * radius * radius * radius * fluid_density;
}

/// κ of one sphere.
/// @param closeness R_eff/R [-], 1 at a wall
inline double lasting_share(double mass, double added, double closeness) {
  const double inertia = (mass + added) / (mass + 7 * added);
  return 2.1 * inertia * inertia * std::sqrt(closeness);
}

/// t [s] of the layer that the contact pays for.
/// @param lasting κ of the sphere [-]
inline double collision_layer_age(double kinematic_viscosity, double collision_time, double h,
                                  double speed, double lasting) {
  const double a = resolved_layer(speed * h / kinematic_viscosity);
  const double thick = (0.5 * collision_time + h * h / (5 * kinematic_viscosity)) / 4;
  const double thin = 0.3 * collision_time + 2.3 * h / speed;
  return a * thick + (1 - a) * lasting * thin;
}

/// β of one sphere.
/// @param added m_a [kg]
/// @param age of the layer, t [s]
inline double viscous_share(double radius, double mass, double added, double fluid_density,
                            double kinematic_viscosity, double age) {
  constexpr double pi = 3.14159265358979323846;
  const double root = 6 * pi * radius * radius * fluid_density *
                      std::sqrt(kinematic_viscosity * age) / (mass + added);
  if (root > 10) return 1;  // a layer far beyond one that is thin against R
  return 1 - std::exp(root * root) * std::erfc(root);
}

/// ε of one sphere.
/// @param added m_a [kg]
/// @param fluid_step Δt of the fluid [s]
/// @param closeness R_eff/R [-], 1 at a wall
inline double late_share(double mass, double added, double fluid_step, double collision_time,
                         double closeness) {
  return 1.8 * added / (mass + added) * fluid_step / collision_time * std::sqrt(closeness);
}

/// β - (1 - a) ε of one sphere, at least 0: what the contact pays.
/// @param viscous β  @param resolved a  @param late ε
inline double paid_share(double viscous, double resolved, double late) {
  return std::max(0.0, viscous - (1 - resolved) * late);
}

/// c [kg/s] of a damper that in a collision of length T_c leaves (1 - β)/(1 + β) of the speed:
///     c = (4 m/T_c) artanh β,
/// as the mean of the speed's square is half of u² (0.555 for the spring δ^{3/2}).
inline double collision_damping(double mass, double collision_time, double share) {
  constexpr double most = 0.9;  // of the speed; far beyond a layer that is thin against R
  return 4 * mass / collision_time * std::atanh(std::min(share, most));
}

}  // namespace bedload::contact
