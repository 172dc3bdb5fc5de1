#pragma once

#include <algorithm>
#include <cmath>

#include "liggghts_styles/formulas/actm_calibration.hpp"
#include "liggghts_styles/formulas/actm_hardening.hpp"

/// Normal force of the adaptive collision time model (ACTM) and its step in a leapfrog integrator.
///
/// Paper: T. Kempe, J. Fröhlich, J. Fluid Mech. 709 (2012), eq. (4.2); enduring contact after
/// E. Biegert, B. Vowinckel, E. Meiburg, J. Comput. Phys. 340 (2017), section 4.
///
/// Symbols: δ overlap [m], w approach speed, positive while the surfaces close in [m/s], m
/// effective mass [kg], k stiffness [N/m^1.5], d damping [kg/s], T_c collision time [s], F force,
/// positive apart [N]. Valid range: 0 < e <= 1, u_in > 0; k and d stay fixed as long as the contact
/// lasts.
namespace bedload::contact {

/// k and d of one contact.
struct ActmCoefficients {
  double stiffness;  ///< k [N/m^1.5]
  double damping;    ///< d [kg/s]
};

/// k = m / sqrt(u t*^5), d = 2 λ m / t*, with t* = T_c / τ.
/// @param mass effective mass [kg]  @param speed calibration speed u > 0 [m/s]
/// @param collision_time T_c [s]
inline ActmCoefficients actm_coefficients(double mass, double speed, double collision_time,
                                          const ActmCalibration& c) {
  const double t = collision_time / c.tau;
  return {mass / (t * t * std::sqrt(speed * t)), 2 * c.lambda * mass / t};
}

/// The same for a stiffness that is prescribed instead of T_c: the unit of time becomes
/// t* = (m / (k sqrt(u)))^{2/5}, so that the collision is shorter and e stays the same.
inline ActmCoefficients actm_coefficients_of_stiffness(double mass, double speed, double stiffness,
                                                       const ActmCalibration& c) {
  const double t = std::pow(mass / (stiffness * std::sqrt(speed)), 0.4);
  return {stiffness, 2 * c.lambda * mass / t};
}

/// Stiffness that lets a weight W press in no further than δ_w:  k δ_w^{3/2} = W  [N/m^1.5].
inline double stiffness_bearing(double weight, double overlap) {
  return weight / (overlap * std::sqrt(overlap));
}

/// Impact speed at which the Stokes number ρ_p u D / (9 ρ_f ν) equals St_crit [m/s].
/// @param viscosity μ = ρ_f ν [Pa s]  @param density_times_diameter ρ_p D [kg/m²]
inline double speed_at_stokes(double stokes, double viscosity, double density_times_diameter) {
  return 9 * stokes * viscosity / density_times_diameter;
}

/// Energy that the spring holds, (2/5) k δ^{5/2} [J].
inline double elastic_energy(double stiffness, double overlap) {
  return 0.4 * stiffness * overlap * overlap * std::sqrt(overlap);
}

/// Force of the spring S = k δ^{3/2} + H(δ) [N].
/// @param overlap δ [m], none below 0  @param hardening H of actm_hardening.hpp
inline double actm_spring(double stiffness, double overlap, const ActmHardening& hardening = {}) {
  if (overlap <= 0) return 0;
  return stiffness * overlap * std::sqrt(overlap) + hardening_force(hardening, overlap);
}

/// Force of a step [N]; the spring's, S [N]; whether the contact ends with this step.
struct ActmStep {
  double force;
  double spring;
  bool last;
};

/// Force of one step of the leapfrog  w⁺ = w⁻ - F Δt/m,  δ⁺ = δ - w⁺ Δt ... taken at overlap δ.
///
///     S = k δ^{3/2} + H(δ),   F = S + W d (w⁻ + w⁺)/2   =>   F = (S + W d w⁻) / (1 + W d Δt / (2
///     m))
///
/// The damping is taken at the middle of the kick, which makes it second order in Δt and stable.
/// The damping force starts and ends with a jump, and a sum over whole steps would count that jump
/// up to one step wrong, a first-order error. W is the part of the kick's interval [-Δt/2, Δt/2]
/// around this step, in units of Δt, during which the surfaces touch:
///     first step:  touched δ/w⁻ ago           W = 1/2 + δ / (w⁻ Δt)
///     last step:   apart δ/|w⁺| from now      W = 1/2 + δ / (|w⁺| Δt)
///     otherwise                               W = 1.
/// @param overlap δ > 0 [m]  @param approach w⁻ [m/s]  @param mass m [kg]  @param dt Δt [s]
/// @param first_step whether the contact was not there a step ago
/// @param hardening H of actm_hardening.hpp
/// @return the force, and whether this step was the last one: the contact is over then, even if
/// rounding of W leaves a trace of overlap at the next step
inline ActmStep actm_step(const ActmCoefficients& c, double overlap, double approach, double mass,
                          double dt, bool first_step, const ActmHardening& hardening = {}) {
  const double spring = actm_spring(c.stiffness, overlap, hardening);
  const double kick = dt / mass;
  const auto force = [&](double part) {
    return (spring + part * c.damping * approach) / (1 + 0.5 * part * c.damping * kick);
  };
  if (first_step) {
    const double travel = approach * dt;
    return {force(0.5 + (overlap < travel ? overlap / travel : 1.0)), spring, false};
  }
  const double whole = force(1.0);
  const double departure = -(approach - whole * kick) * dt;  // way apart in the coming step
  if (overlap < departure) return {force(0.5 + overlap / departure), spring, true};
  return {whole, spring, false};
}

}  // namespace bedload::contact
