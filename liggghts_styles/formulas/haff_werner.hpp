#pragma once

#include <cmath>
#include <numbers>

/// Tangential force of Haff and Werner.
///
/// Paper: P. K. Haff, B. T. Werner, "Computer simulation of the mechanical sorting of grains",
/// Powder Technol. 48 (1986):
///     F_t = -min(d_t |g_t|, μ |F_n|) t
/// with g_t the relative tangential velocity at the contact point, spins included. No memory.
/// F_n is taken without its damping part here, whose impulse over a collision is zero.
///
/// Symbols: d_t tangential damping [kg/s]; μ friction coefficient [-]; F_n normal force [N];
/// M_t [kg] the mass that a tangential force at the contact point feels,
///     1/M_t = 1/m + R_p²/I_p + R_q²/I_q,   R²/I = 5/(2 m_p) for a sphere.
/// Valid range: any Δt, see haff_werner_step_damping.
namespace bedload::contact {

/// M_t [kg] of two spheres: 1/M_t = 7/2 (1/m_p + 1/m_q) = 7/(2 m).
/// @param effective_mass m [kg]; that of the other where one partner cannot move
inline double tangential_mass(double effective_mass) { return 2.0 / 7.0 * effective_mass; }

/// Damping [kg/s] that acts on the slip velocity at the start of a step of length Δt such that the
/// law's damping acts on the one at its end, g_t⁺ = g_t⁻ - F_t Δt/M_t:
///     d_t |g_t|⁺ = d_t / (1 + d_t Δt/M_t) |g_t|⁻.
/// Friction then stops the slip but never turns it, whatever Δt; d_t Δt/M_t << 1 gives d_t back.
/// @param mass M_t [kg]
inline double haff_werner_step_damping(double damping, double mass, double dt) {
  return damping / (1 + damping * dt / mass);
}

/// The same for a damping that is given as the time T in which slip dies away, d_t = M_t/T:
///     M_t / (T + Δt).
/// @param mass M_t [kg]
inline double haff_werner_relaxing_damping(double relaxation, double mass, double dt) {
  return mass / (relaxation + dt);
}

/// What a viscous fluid opposes to slip [kg/s], from the Stokes drag and torque on single spheres:
///     1/ζ = Σ (1/(6πμ_f R) + R²/(8πμ_f R³)) = 7/(24πμ_f) Σ 1/R.
/// A torque of the fluid's that would turn a sphere at a slip of g_f without friction leaves
/// ζ/(ζ + d_t) of it with friction: d_t << ζ is none at all, whatever μ.
/// @param inverse_radii Σ 1/R over the partners that can move [1/m]
inline double viscous_slip_resistance(double viscosity, double inverse_radii) {
  return 24 * std::numbers::pi * viscosity / (7 * inverse_radii);
}

/// Share of a slip driven by viscosity that friction may leave, by default. Between other spheres,
/// where viscosity holds more, it is up to four times as much.
inline constexpr double slip_left_to_viscosity = 0.02;

/// T such that M_t/T leaves that share: slip has to die away faster than viscosity drives it.
inline double haff_werner_viscous_relaxation(double mass, double resistance) {
  return mass * slip_left_to_viscosity / ((1 - slip_left_to_viscosity) * resistance);
}

/// |F_t|/|g_t| = min(d_t, μ |F_n| / |g_t|) [kg/s]. The usual case, no sliding, needs no root.
/// @param slip_squared |g_t|² [m²/s²]  @param cap μ |F_n| [N]
inline double haff_werner_force_per_slip(double damping, double slip_squared, double cap) {
  if (damping * damping * slip_squared <= cap * cap) return damping;
  return cap / std::sqrt(slip_squared);
}

/// Where a contact that endures shall bear a load at rest (not in the paper, off by default): a
/// spring beside the damping, after Cundall and Strack, Géotechnique 29 (1979),
///     F_t = -(k_t s + d_t g_t), |F_t| <= μ |F_n|,   s = ∫ g_t dt, no longer than μ |F_n| / k_t.
/// @return factor <= 1 by which the trial force -(k_t s + d_t g_t) is cut
/// @param trial_squared its square [N²]  @param cap μ |F_n| [N]
inline double coulomb_cut(double trial_squared, double cap) {
  return trial_squared <= cap * cap ? 1.0 : cap / std::sqrt(trial_squared);
}

}  // namespace bedload::contact
