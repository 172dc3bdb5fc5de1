#pragma once

#include <algorithm>
#include <cmath>

/// What becomes of the fluid's load in a collision that is stretched to T_c.
///
/// A real collision takes microseconds: the fluid neither turns nor squeezes while it lasts. In one
/// stretched to some fluid steps both act on the sphere, late and from markers inside the wall. So
/// the contact bears what the relative acceleration A of the two surfaces by the fluid's loads has
/// changed by since the touch,
///     F = -w m (A - A_0),   A = n·(L_i/m_i - L_j/m_j),
/// equal and opposite on both. What was there before, weight, stream and drag, acts on: a constant
/// load does no work in a contact that ends where it began. In exchange a damper takes what
/// viscosity would have taken. A sphere whose speed jumps by Δu loses Basset's impulse until the
/// layer along it is as old as t,
///     β m Δu,   β = 12 R² ρf sqrt(π ν t)/m,
/// and the run has let the layer grow for T_c/2 at the contact's cost, to which the kernel's width
/// adds:  ν t = ν T_c/2 + h²/8. Half of that impulse is what the peaks of a rebound at St = 27 ask
/// for, at D/h = 8 to 16 and for T_c of five and ten steps; the rest comes late, in flight.
///
/// Symbols: L load of the fluid [N]; m_i, m_j masses, m the reduced one [kg]; w weight [-]; u speed
/// at the touch [m/s]; St = ρp u D/(9 μ), Re = u D/ν of the heavier partner; h cell size [m].
/// Valid range: layers, not wakes; see collision_weight.
namespace bedload::contact {

/// w: 0 up to St = 5, where a contact is an enduring one by default (at St = 5 at the touch the
/// film has taken as much again, and nothing rebounds below), 1 from 10 on; 1 up to Re = 25, where
/// the flow begins to separate from a sphere, and 0 from 50 on: Basset's force says what viscosity
/// takes from a layer, not from a wake.
inline double collision_weight(double stokes, double reynolds) {
  const double rise = std::clamp((stokes - 5) / 5, 0.0, 1.0);
  const double fall = std::clamp((50 - reynolds) / 25, 0.0, 1.0);
  return rise * fall;
}

/// ν t [m²] of the layer that a collision of length T_c has made the contact pay for.
inline double collision_layer(double kinematic_viscosity, double collision_time, double h) {
  return 0.5 * kinematic_viscosity * collision_time + 0.125 * h * h;
}

/// Half of β of one sphere.
/// @param layer ν t [m²]
inline double viscous_share(double radius, double mass, double fluid_density, double layer) {
  constexpr double pi = 3.14159265358979323846;
  return 6 * radius * radius * fluid_density * std::sqrt(pi * layer) / mass;
}

/// c [kg/s] of a damper that in a collision of length T_c leaves (1 - β)/(1 + β) of the speed:
///     c = (4 m/T_c) artanh β,
/// as the mean of the speed's square is half of u² (0.555 for the spring δ^{3/2}).
inline double collision_damping(double mass, double collision_time, double share) {
  constexpr double most = 0.9;  // of the speed; far beyond a layer that is thin against R
  return 4 * mass / collision_time * std::atanh(std::min(share, most));
}

}  // namespace bedload::contact
