#pragma once

#include <cmath>

/// Repulsive potential model (RPM).
///
/// Paper: R. Glowinski, T.-W. Pan, T. I. Hesla, D. D. Joseph, J. Périaux, J. Comput. Phys. 169
/// (2001); in the form printed by B. Vowinckel, T. Kempe, J. Fröhlich, "Impact of collision models
/// on particle transport in open channel flow":
///     F = ε m_p g (max{0, -(ζ - S)/S})²
///
/// Symbols: ζ surface gap [m], negative in overlap; S range [m]; ε strength [-]; m_p mass of the
/// particle [kg]; g gravitational acceleration [m/s²].
/// Valid range: S > 0. The force keeps growing in overlap; it does no work over a collision.
namespace bedload::contact {

/// F [N], positive apart.
inline double rpm_force(double gap, double range, double strength, double weight) {
  const double depth = gap < range ? (range - gap) / range : 0.0;
  return strength * weight * depth * depth;
}

/// Strength ε with which a head-on collision at speed u lasts the time T in the absence of weight.
///
/// With the depth z = S - ζ and m z'' = -C z², C = ε m_p g / S²: the energy gives
/// z_max³ = 3 m u² / (2 C), and  T = κ z_max / u  with κ = 2 ∫₀¹ dy / sqrt(1 - y³) = 2.80436.
/// Hence C = (3/2) m u² (κ / (u T))³. T ~ u^{-1/3}: slower collisions last longer.
/// @param mass_ratio m / m_p, effective mass over the mass in the formula: 1 against a wall, 1/2
/// between two equal spheres
inline double rpm_strength(double speed, double duration, double range, double gravity,
                           double mass_ratio) {
  constexpr double kappa = 2.8043642106509086;
  const double q = kappa / (speed * duration);
  return 1.5 * mass_ratio * speed * speed * q * q * q * range * range / gravity;
}

/// Duration [s] of a head-on collision at speed u with the strength ε, the inverse of
/// rpm_strength().
inline double rpm_duration(double speed, double strength, double range, double gravity,
                           double mass_ratio) {
  const double of_unit_time = rpm_strength(speed, 1.0, range, gravity, mass_ratio);
  return std::cbrt(of_unit_time / strength);  // ε T³ is the same for all
}

/// Speed at which a partner that is let go at a gap leaves the range: the energy
///     ε m_p g S (max{0, S - ζ}/S)³/3
/// of the repulsion there becomes that of m. [m/s]
inline double rpm_parting_speed(double gap, double range, double strength, double gravity,
                                double mass_ratio) {
  const double depth = gap < range ? (range - gap) / range : 0.0;
  return std::sqrt(2.0 / 3.0 * strength * gravity * range * depth * depth * depth / mass_ratio);
}

}  // namespace bedload::contact
