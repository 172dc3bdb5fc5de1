#pragma once

#include <algorithm>

/// Tangential force of Haff and Werner.
///
/// Paper: P. K. Haff, B. T. Werner, "Computer simulation of the mechanical sorting of grains",
/// Powder Technol. 48 (1986):
///     F_t = -min(d_t |g_t|, μ |F_n|) t
/// with g_t the relative tangential velocity at the contact point, spins included. No memory.
///
/// Symbols: d_t tangential damping [kg/s]; μ friction coefficient [-]; F_n normal force [N];
/// M_t [kg] the mass that a tangential force at the contact point feels,
///     1/M_t = 1/m + R_p²/I_p + R_q²/I_q,   R²/I = 5/(2 m_p) for a sphere.
/// Valid range: any Δt, see haff_werner_step_force.
namespace bedload::contact {

/// M_t [kg] of two spheres: 1/M_t = 7/2 (1/m_p + 1/m_q) = 7/(2 m).
/// @param effective_mass m [kg]; that of the other where one partner cannot move
inline double tangential_mass(double effective_mass) { return 2.0 / 7.0 * effective_mass; }

/// |F_t| [N] from the formula.
inline double haff_werner_force(double damping, double slip_speed, double friction, double normal) {
  return std::min(damping * slip_speed, friction * normal);
}

/// |F_t| of one step of length Δt that starts with the slip speed |g_t|⁻. The damping acts on the
/// slip speed at the end of the kick, |g_t|⁺ = |g_t|⁻ - F_t Δt/M_t:
///     F_t = min(d_t |g_t|⁻ / (1 + d_t Δt/M_t), μ |F_n|)
/// so that friction stops the slip but never turns it, whatever Δt; d_t Δt/M_t << 1 gives the
/// formula back.
/// @param mass M_t [kg]
inline double haff_werner_step_force(double damping, double slip_speed, double friction,
                                     double normal, double mass, double dt) {
  return haff_werner_force(damping / (1 + damping * dt / mass), slip_speed, friction, normal);
}

/// The same for a damping that is given as the time T in which slip dies away, d_t = M_t/T:
///     F_t = min(M_t |g_t|⁻ / (T + Δt), μ |F_n|).
/// @param mass M_t [kg]
inline double haff_werner_relaxing_force(double relaxation, double slip_speed, double friction,
                                         double normal, double mass, double dt) {
  return haff_werner_force(mass / (relaxation + dt), slip_speed, friction, normal);
}

}  // namespace bedload::contact
