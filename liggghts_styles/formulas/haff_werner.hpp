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

/// 1/M_t [1/kg] of two spheres; a partner that cannot move enters with inverse mass 0.
/// @param inverse_mass_i, inverse_mass_j 1/m_p and 1/m_q [1/kg]
inline double tangential_inverse_mass(double inverse_mass_i, double inverse_mass_j) {
  return 3.5 * (inverse_mass_i + inverse_mass_j);
}

/// |F_t| [N] from the formula.
inline double haff_werner_force(double damping, double slip_speed, double friction, double normal) {
  return std::min(damping * slip_speed, friction * normal);
}

/// |F_t| of one step of length Δt that starts with the slip speed |g_t|⁻. The damping acts on the
/// slip speed at the end of the kick, |g_t|⁺ = |g_t|⁻ - F_t Δt/M_t:
///     F_t = min(d_t |g_t|⁻ / (1 + d_t Δt/M_t), μ |F_n|)
/// so that friction stops the slip but never turns it, whatever Δt; d_t Δt/M_t << 1 gives the
/// formula back.
inline double haff_werner_step_force(double damping, double slip_speed, double friction,
                                     double normal, double inverse_mass, double dt) {
  return haff_werner_force(damping / (1 + damping * dt * inverse_mass), slip_speed, friction,
                           normal);
}

}  // namespace bedload::contact
