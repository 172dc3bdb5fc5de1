#pragma once

#include <algorithm>
#include <cmath>

/// Lubrication force along the line of centres, and its exact step.
///
/// Papers: S. Kim, S. J. Karrila, "Microhydrodynamics" (1991), leading order of the squeezing mode;
/// with the cut-off gap of E. Biegert, B. Vowinckel, E. Meiburg, J. Comput. Phys. 340 (2017):
///     F = -c g_n n,   c = 6 π μ R_eff² / max(ζ, ζ_min),   0 < ζ <= range
///     R_eff = R_p R_q / (R_p + R_q), and R_p against a wall.
/// (Vowinckel, Kempe, Fröhlich print R_eff without the square; the dimensions ask for it.)
///
/// Symbols: μ dynamic viscosity [Pa s]; ζ surface gap [m]; g_n rate at which the gap opens [m/s].
/// Valid range: 0 < ζ, in overlap the caller applies nothing.
namespace bedload::contact {

/// c [kg/s].
inline double lubrication_coefficient(double viscosity, double effective_radius, double gap,
                                      double smallest_gap) {
  constexpr double pi = 3.14159265358979323846;
  return 6 * pi * viscosity * effective_radius * effective_radius / std::max(gap, smallest_gap);
}

/// φ1(x) = (1 - e^{-x}) / x: what a damping rate x/Δt leaves on average over a step Δt.
inline double damped_mean(double x) { return x < 1e-5 ? 1 - 0.5 * x : -std::expm1(-x) / x; }

/// φ2(x) = (1 - φ1(x)) / x.
inline double damped_mean_of_ramp(double x) {
  return x < 1e-3 ? 0.5 - x / 6 * (1 - 0.25 * x) : (1 - damped_mean(x)) / x;
}

/// Mean force over a step of length Δt in which g_n' = a - (x/Δt) g_n, starting from g_n⁻:
///     F = -c (φ1(x) g_n⁻ + φ2(x) a Δt)
/// With x = c Δt / m this is the exact solution for a constant gap: any Δt is stable, the approach
/// never turns into a rebound, a pushed pair closes at a m / c, and x << 1 gives -c g_n back.
/// @param opening g_n⁻ [m/s]  @param acceleration a, of the gap by all other forces [m/s²]
inline double lubrication_step_force(double coefficient, double opening, double acceleration,
                                     double dt, double x) {
  return -coefficient * (damped_mean(x) * opening + damped_mean_of_ramp(x) * acceleration * dt);
}

/// D [1/kg] of a film, for films that share spheres. The force above is F = -(φ1 g_n/(φ2 Δt) + a) /
/// D with  D = 1 / (c φ2(x) Δt).  The other films add to the acceleration a: with A_kl the
/// acceleration of gap k by a unit force of film l (A_kk = 1/m_k)
///     D_k F_k + Σ_{l≠k} A_kl F_l = D_k F_k,alone.
/// D_k > 1/m_k, so the matrix A + diag(D_k - 1/m_k) is symmetric and positive definite. x -> 0
/// gives each film alone, x -> inf  F_k = -c_k g_k at the end of the step: the films of a pushed
/// sphere yield as the formula says. Kinetic energy does not grow without other forces (20 000
/// random clusters: largest singular value of the step 1 to round-off).
inline double lubrication_step_compliance(double coefficient, double dt, double x) {
  return 1 / (coefficient * damped_mean_of_ramp(x) * dt);
}

}  // namespace bedload::contact
