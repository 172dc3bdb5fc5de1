#pragma once

#include <algorithm>
#include <cmath>

/// What becomes of the fluid's load in a collision that is stretched to T_c.
///
/// A real collision takes microseconds: the fluid neither turns nor squeezes while it lasts. In one
/// stretched to some fluid steps it does, late. So the contact bears what the relative acceleration
/// A of the two surfaces by the fluid's loads has changed by since the touch,
///     F = -w m (A - A_0),   A = n·(L_i/m_i - L_j/m_j),
/// equal and opposite on both. What was there before, weight, stream and drag, acts on: a constant
/// load does no work in a contact that ends where it began. In exchange a damper takes what
/// viscosity would have taken. A sphere whose speed jumps by Δu loses Basset's impulse until the
/// layer along it is as old as t,
///     β m Δu,   β = κ 12 R² ρf sqrt(π ν t)/m,
/// and the run has let the layer grow for T_c/2 at the contact's cost. To that comes what the grid
/// does not resolve of the layer:
///     ν t = ν T_c/2 + a h²/8 + (1 - a) ν 1.25 h/u,   κ = 1 - a/2.
/// a = 1: the layer is thicker than the kernel, whose width adds to it, and half of the impulse
/// comes later all the same, in flight. a = 0: it is thinner, and the grid knows of none until the
/// sphere has left the reach of its kernel. Peaks of rebounds at St = 27 (a = 1, D/h = 8 to 16,
/// collisions of five and ten steps) and 152 (a = 0) ask for the numbers.
///
/// Symbols: L load of the fluid [N]; m_i, m_j masses, m the reduced one [kg]; w weight [-]; u speed
/// at the touch [m/s]; St = ρp u D/(9 μ) of the heavier partner; h cell size [m].
namespace bedload::contact {

/// w: 0 up to St = 5, where a contact is an enduring one by default (at St = 5 at the touch the
/// film has taken as much again, and nothing rebounds below), 1 from 10 on.
inline double collision_weight(double stokes) { return std::clamp((stokes - 5) / 5, 0.0, 1.0); }

/// a: when the sphere has moved by a cell, its layer is as thick as sqrt(ν h/u) = h/sqrt(Re_h);
/// 1 up to Re_h = u h/ν = 4, 0 from 12 on.
inline double resolved_layer(double cell_reynolds) {
  return std::clamp((12 - cell_reynolds) / 8, 0.0, 1.0);
}

/// ν t [m²] of the layer that the contact pays for.
/// @param resolved a
inline double collision_layer(double kinematic_viscosity, double collision_time, double h,
                              double speed, double resolved) {
  const double age = 0.5 * collision_time + (1 - resolved) * 1.25 * h / speed;
  return kinematic_viscosity * age + resolved * 0.125 * h * h;
}

/// β of one sphere.
/// @param layer ν t [m²]
inline double viscous_share(double radius, double mass, double fluid_density, double layer,
                            double resolved) {
  constexpr double pi = 3.14159265358979323846;
  return (1 - 0.5 * resolved) * 12 * radius * radius * fluid_density * std::sqrt(pi * layer) / mass;
}

/// c [kg/s] of a damper that in a collision of length T_c leaves (1 - β)/(1 + β) of the speed:
///     c = (4 m/T_c) artanh β,
/// as the mean of the speed's square is half of u² (0.555 for the spring δ^{3/2}).
inline double collision_damping(double mass, double collision_time, double share) {
  constexpr double most = 0.9;  // of the speed; far beyond a layer that is thin against R
  return 4 * mass / collision_time * std::atanh(std::min(share, most));
}

}  // namespace bedload::contact
