#pragma once

#include <cmath>
#include <limits>

#include "liggghts_styles/formulas/diffusion_number.hpp"

/// Lubrication force along the line of centres, and its exact step.
///
/// Papers: S. Kim, S. J. Karrila, "Microhydrodynamics" (1991), leading order of the squeezing mode;
/// with the cut-off gap of E. Biegert, B. Vowinckel, E. Meiburg, J. Comput. Phys. 340 (2017):
///     F = -c g_n n,   c = 6 π μ R_eff² / max(ζ, ζ_min),   0 < ζ <= range
///     R_eff = R_p R_q / (R_p + R_q), and R_p against a wall.
/// (Vowinckel, Kempe, Fröhlich print R_eff without the square; the dimensions ask for it.)
///
/// What a fluid grid of spacing h resolves of the film is in the fluid's force already, so with one
/// the model is  exact - resolved  at every gap:
///     c = 6 π μ R_eff² S(ζ/h) / max(ζ, ζ_min)      apart,
///     c = -6 π μ R_eff² G / h                      in a collision,
///     c = 6 π μ R_eff² / ζ_min                     in an enduring contact;
/// in a collision as far as the contact does not bear the fluid's load (collision_in_fluid.hpp).
/// S, the share of the film that is not resolved, and G, what is resolved as surfaces touch, are
/// measured with the immersed boundary of this project in Stokes flow, spheres held and moving at
/// gaps of 0.1 to 4 h and 8 to 16 cells to a diameter, against Brenner's exact forces
/// (`./bedload study validation film`): they depend on ζ/h and on the time step.
/// In a collision, which is stretched and has no duration in nature, the exact film has no time to
/// act, and the resolved one has. In an enduring contact rough surfaces lie on each other with
/// ζ_min between them, and the film there is that of a gap of ζ_min: without it a grain that is
/// pressed into contact in a viscous fluid would swing on the contact's spring, undamped.
///
/// Symbols: μ dynamic viscosity [Pa s]; ζ surface gap [m]; g_n rate at which the gap opens [m/s].
/// Valid range: 0 < ζ; in overlap the published law is 0.
namespace bedload::contact {

/// 6 π μ R_eff² [N s]: c of a film times its gap.
inline double lubrication_strength(double viscosity, double effective_radius) {
  constexpr double pi = 3.14159265358979323846;
  return 6 * pi * viscosity * effective_radius * effective_radius;
}

/// S(s) = (1 - s/s_0) exp(-a s - b s²), s = ζ/h: how much of the film the grid does not resolve,
/// below 0 where it resolves more than there is; and G.
struct UnresolvedShare {
  double linear, square;
  double resolved_at_touch;                                          ///< G
  double all_resolved_at = std::numeric_limits<double>::infinity();  ///< s_0
  double operator()(double cells) const {
    return (1 - cells / all_resolved_at) * std::exp(-cells * (linear + square * cells));
  }
};
/// Where two spheres share cells the markers of either stand back
/// (fluid/immersed_boundary/README.md, "Surfaces in the same cells"), and so do those beside a
/// wall, but not so far that nobody would hold the fluid between them: the less slip a step leaves
/// there, the more of a film does the grid resolve. At a wall, with λ (diffusion_number_of_loop and
/// diffusion_number_of_approach)
///     G = 1.8 - 0.23 ln(λ/0.05) = a,   b = 0.8.
inline UnresolvedShare unresolved_at_wall(double diffusion_number) {
  const double resolved =
      1.8 - 0.23 * std::log(diffusion_number_of_approach(diffusion_number) / 0.05);
  return {resolved, 0.8, resolved};
}

/// Between spheres
///     s_0 = 0.727 (λ/0.05)^0.28,   G = 1.88 (λ/0.05)^-0.28.
inline UnresolvedShare unresolved_of_pair(double diffusion_number) {
  constexpr double power = 0.28;
  const double scale = std::pow(diffusion_number_of_approach(diffusion_number) / 0.05, power);
  return {0.37, 1.02, 1.88 / scale, 0.727 * scale};
}

/// A free-slip wall is the plane of symmetry between a sphere and its image, with R_eff = R/2 at
/// twice the gap, which opens at 2 g_n:
///     c = 6 π μ (R/2)² 2 [...](2 ζ) = 1/2 6 π μ R² [...](2 ζ),
/// [...] what stands behind R_eff² above, of a pair. A quarter of a no-slip wall's film, so, where
/// the grid resolves none.
inline constexpr double mirrored_share = 0.5;

/// Mean of 1/max(ζ, ζ_min) over the way that the gap makes in a step, from ζ - w/2 to ζ + w/2, of
/// which what is below 0 counts nothing: film impulses add up over steps to the exact logarithm of
/// the gaps, wherever between two steps the surfaces touch. [1/m]
/// @param gap ζ at the middle of the step, may be below 0 [m]  @param way w >= 0 [m]
inline double mean_inverse_gap(double gap, double way, double smallest_gap) {
  const double upper = gap + 0.5 * way;
  if (upper <= 0) return 0;
  const double lower = std::max(0.0, gap - 0.5 * way);
  if (upper - lower < 1e-6 * upper) return 1 / std::max(gap, smallest_gap);
  const auto integral = [&](double z) {  // from 0 to z
    return z < smallest_gap ? z / smallest_gap : 1 + std::log(z / smallest_gap);
  };
  return (integral(upper) - integral(lower)) / way;
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
