#pragma once

#include <algorithm>
#include <cmath>

/// Hardening of ACTM's spring under loads that its calibration does not know.
///
/// k is calibrated for the effective mass of the two surfaces that meet. Where a third body leans
/// on a light one of them (a heavy grain on a light grain that lies on a wall: both contacts have
/// the light mass), that spring is entered deeper than any impact that it was calibrated for, by
/// the power 2/5 of the ratio of the masses: by more than a radius at 64. Beyond the overlap that
/// the impact can reach, a second spring is therefore added,
///
///     H(ε) = K ε² / (ε + b),   ε = δ - δ_h > 0,   b = δ_h / 8,   0 for ε <= 0.
///
/// H is a function of δ alone, so it has a potential and makes no energy. H and dH/dδ are 0 at the
/// onset δ_h, so the force is smooth there; dH/dδ grows to K and never beyond, so the step resolves
/// it at any depth.
///
/// Symbols: δ overlap [m], u speed of the calibration [m/s], m effective mass [kg], k stiffness
/// [N/m^1.5], X largest overlap of the calibrated collision over u t* [-] (1.093 at e = 1), g'
/// submerged gravity [m/s²], Δt step of the integrator [s], ω angular frequency [1/s].
namespace bedload::contact {

/// Second spring of one contact. Both stay fixed as long as the contact lasts, but for a longer
/// step (resolved_slope).
struct ActmHardening {
  double onset = 0;  ///< δ_h [m]
  double slope = 0;  ///< K [N/m]
};

/// Onset δ_h over the largest overlap expected: steps, and what the fluid pushes, add some per cent
/// to it (3.5 % at the coarsest step). [-]
inline constexpr double hardening_onset = 1.1;

/// Width b of the bend, over the onset. [-]
inline constexpr double hardening_bend = 0.125;

/// Largest ω Δt of the hardened spring, and of that of enduring contacts. Two such contacts on one
/// grain have sqrt(2) of it, twelve in a dense packing at most 4 times it: below the 2 that
/// leapfrog bears. [-]
inline constexpr double resolved_phase = 0.3;

/// Largest overlap of a frictionless impact at u while the weight of m presses, from above:
///
///     (2/5) k δ^{5/2} = m u²/2 + m g' δ   =>   δ <= X (m u²/k)^{2/5} + (5 m g' / (2 k))^{2/3}
///
/// (the two overlaps that either of them reaches alone; δ^{5/2} grows faster than linearly, so
/// their sum holds both energies).
inline double largest_overlap_expected(double mass, double speed, double gravity, double stiffness,
                                       double largest_overlap) {
  return largest_overlap * std::pow(mass * speed * speed / stiffness, 0.4) +
         std::pow(2.5 * mass * gravity / stiffness, 2.0 / 3.0);
}

/// K that brings the whole spring to ω Δt = resolved_phase; 0 where k alone is as stiff. A step
/// that grows while the contact lasts (`time.cfl`) lowers it: that takes energy away and makes
/// none.
/// @param onset δ_h [m]  @param stiffness k [N/m^1.5]  @param mass m [kg]  @param dt Δt [s]
inline double resolved_slope(double onset, double stiffness, double mass, double dt) {
  const double stiffest = mass * (resolved_phase / dt) * (resolved_phase / dt);
  return std::max(0.0, stiffest - 1.5 * stiffness * std::sqrt(onset));
}

/// Onset beyond the overlap expected, and the slope that the step resolves.
/// @param expected overlap [m]  @param stiffness k [N/m^1.5]  @param mass m [kg]  @param dt Δt [s]
inline ActmHardening actm_hardening(double expected, double stiffness, double mass, double dt) {
  const double onset = hardening_onset * expected;
  return {onset, resolved_slope(onset, stiffness, mass, dt)};
}

/// H [N], apart.
inline double hardening_force(const ActmHardening& h, double overlap) {
  const double beyond = overlap - h.onset;
  if (beyond <= 0 || h.slope == 0) return 0;
  return h.slope * beyond * beyond / (beyond + hardening_bend * h.onset);
}

/// Energy that the second spring holds, K (ε²/2 - b ε + b² ln(1 + ε/b)) [J].
inline double hardening_energy(const ActmHardening& h, double overlap) {
  const double beyond = overlap - h.onset;
  if (beyond <= 0 || h.slope == 0) return 0;
  const double bend = hardening_bend * h.onset;
  return h.slope * (beyond * (0.5 * beyond - bend) + bend * bend * std::log1p(beyond / bend));
}

}  // namespace bedload::contact
