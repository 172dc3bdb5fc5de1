#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "liggghts_styles/formulas/diffusion_number.hpp"

/// Lubrication of surfaces that slide and roll on each other: force and torques that grow with the
/// logarithm of the gap.
///
/// Papers: A. J. Goldman, R. G. Cox, H. Brenner, Chem. Eng. Sci. 22 (1967) 637, sphere and wall;
/// D. J. Jeffrey, Y. Onishi, J. Fluid Mech. 139 (1984) 261, two spheres of any size. Their leading
/// terms together (all coefficients that the papers list separately, reciprocity included, follow,
/// and are tested) say that a film dissipates, with Λ the logarithm,
///     P = π μ R (2 Λ_s s² + 4.8 Λ_e e²),    R = a b / (a + b), and a at a wall,
/// in two motions of its surfaces, seen from the line of centres:
///     s = v + n x (a ω_i + b ω_j)               one slides on the other,
///     e = (χ v + n x (a ω_i - b ω_j)) / 2       both run through the gap, mean of their
///     velocities, χ = (a - b) / (a + b), and -1 at a wall.
/// The 2 is the shear in the gap; the 4.8 is the pressure in front of and behind it, which follows
/// from Reynolds's equation with the gap ρ²/(2R): p = -9.6 μ e R² cos θ/ρ³. Sliding bears no
/// pressure of its own. So the film is two dampers,
///     f_s = -2 π μ R Λ_s s,    f_e = -4.8 π μ R Λ_e e,
///     F_i = f_s + χ f_e / 2 = -F_j,
///     T_i = -a n x (f_s + f_e / 2),    T_j = -b n x (f_s - f_e / 2).
/// At a wall this is 8/15 of 6πμa v Λ against sliding, 2/5 of 8πμa³ ω Λ against turning, and 2/15
/// of 6πμa² between them.
///
/// What a fluid grid of spacing h lacks of it: the film between the gaps z and z + dz adds dz/z to
/// the logarithm, of which the grid does not resolve the share S(z/h), as of the squeezing force
/// (formulas/lubrication.hpp). Λ is the sum over all gaps wider than this one,
///     Λ = ∫_ζ^∞ S(z/h) dz/z = E1(k ζ/h)        for S = exp(-k z/h), beside walls,
///                           = E1(k ζ²/h²)/2    for S = exp(-k z²/h²), between spheres,
/// which is ln(0.56 h/(k ζ)) and ln(0.75 h/(√k ζ)) at small gaps and nothing at wide ones. k is
/// measured with spheres held at gaps of 0.05 to 2 h that say they slide, turn, or turn against
/// each other, Stokes flow (`./bedload study validation sliding`; beside walls 8 and 12 cells to a
/// diameter, between spheres 8).
///
/// Between spheres most of that is what markers leave out that stand back from the cells they share
/// with another sphere's (fluid/immersed_boundary/README.md), in contact, too:
///     Λ = A exp(-a ζ/h - b ζ²/h²),   ζ >= 0,
/// makes the grid as good as without that; with a fluid every pair gets it (FixMarkerFilm).
/// Measured as the difference of two programs, all markers (commit 3988db8) and these, at gaps of
/// 0.002 to 1.25 h and D/h = 8, two spheres that turn the same way or against each other (the same
/// case of the study has both), with ν Δt/h² = 0.2. The less slip a step leaves, the more do the
/// markers that are left resolve by themselves, and so much less is missing; with λ of
/// formulas/diffusion_number.hpp
///     Λ_s: 0.19 ln(0.2/λ) exp(-0.3 ζ/h - 1.3 ζ²/h²),   Λ_e: 0.11 ln(0.2/λ) exp(-0.9 ζ²/h²),
/// measured there from λ = 0.003 on, by steps as by loops.
///
/// Beside a wall of the fluid they stand back, too. What they leave there is no damper of one
/// motion: the cap that stands back pushes no fluid any more, and on coarse grids it is a larger
/// part of the sphere. So it is a symmetric matrix over v and w = n x a ω,
///     F = -2 π μ R (Λ_v v + Λ_vω w),    T = -a n x F',    F' = -2 π μ R (Λ_vω v + Λ_ω w),
/// with s = ζ/h and c = h/(2a),
///     Λ_v:  1.85 exp(-1.1 s - 2.25 s²)            - L (0.15 E + 0.113 exp(1.4 s - 2.5 s²)),
///     Λ_vω: (0.39 + 11.2 c²) exp(-s - 2.3 s²)     - L (0.1 + 1.65 c²) E,
///     Λ_ω:  (0.485 + 170 c⁴) exp(-1.95 s - 2 s²)  - L (0.15 + 60 c⁴) E,
///     L = ln(0.2/λ),    E = exp(-1.2 s - 1.2 s²),
/// each at least 0, Λ_vω at most Λ_v and Λ_ω at least Λ_vω²/Λ_v, so that nothing is ever driven.
/// Measured as the difference of two programs (commits 67145bd and 8b69049) that see the same
/// sphere slide and turn, D/h = 4 to 12, s = 0.002 to 1.
///
/// Symbols: μ dynamic viscosity [Pa s]; ζ surface gap [m]; n unit vector from j to i; a, b radii
/// [m]; v velocity of i relative to j, ω spins [1/s]. The arms a and b reach to the middle of the
/// gap, so that they sum to the distance of the centres: then a pair that turns as one body feels
/// nothing, and no angular momentum is made. Valid range: 0 < ζ. Spin about n makes no logarithm
/// and is left out.
namespace bedload::contact {

using Vector3 = std::array<double, 3>;

/// One number for each of both motions.
struct SlideAndRoll {
  double slide, roll;
};

/// k: of the share that the grid does not resolve.
inline constexpr SlideAndRoll tangential_unresolved_at_wall{3.1, 2.4};
inline constexpr SlideAndRoll tangential_unresolved_of_pair{1.27, 4.8};

/// Λ = E1(x), x = k ζ/h > 0, to 2e-7 for x < 1 and 5e-5 of itself above (Abramowitz and Stegun,
/// Handbook of Mathematical Functions, 5.1.53 and 5.1.54).
inline double unresolved_logarithm(double x) {
  if (x < 1) {
    constexpr double series[] = {-0.57721566, 0.99999193,  -0.24991055,
                                 0.05519968,  -0.00976004, 0.00107857};
    double sum = 0;
    for (int n = 5; n >= 0; --n) sum = series[n] + x * sum;
    return sum - std::log(x);
  }
  return std::exp(-x) / x * (x * (x + 2.334733) + 0.250621) / (x * (x + 3.330657) + 1.681534);
}

/// Λ of both motions that a grid lacks at a wall. @param cells ζ/h
inline SlideAndRoll logarithms_lacking_at_wall(double cells) {
  constexpr SlideAndRoll k = tangential_unresolved_at_wall;
  return {unresolved_logarithm(k.slide * cells), unresolved_logarithm(k.roll * cells)};
}

/// The same between two spheres.
inline SlideAndRoll unresolved_logarithms_of_pair(double cells) {
  constexpr SlideAndRoll k = tangential_unresolved_of_pair;
  const double square = cells * cells;
  return {0.5 * unresolved_logarithm(k.slide * square),
          0.5 * unresolved_logarithm(k.roll * square)};
}

/// Widest gap at which markers leave something worth counting (1 % of what they leave at the touch)
/// [cells].
inline constexpr double left_by_markers_to = 1.25;

/// `all` without `given`, and nothing where that is more. @param all Λ  @param given Λ
inline SlideAndRoll rest_of(const SlideAndRoll& all, const SlideAndRoll& given) {
  return {std::max(0.0, all.slide - given.slide), std::max(0.0, all.roll - given.roll)};
}

/// ln(0.2/λ)
inline double shorter_than_longest(double diffusion_number) {
  return std::log(longest_diffusion_number / measured_diffusion_number(diffusion_number));
}

/// Λ that the grid resolves of two spheres because the fluid's step leaves less slip than one of
/// ν Δt/h² = 0.2. @param cells ζ/h, may be below 0 in contact  @param diffusion_number λ
inline SlideAndRoll logarithms_of_short_steps(double cells, double diffusion_number) {
  const double s = std::max(cells, 0.0);
  const double shorter = shorter_than_longest(diffusion_number);
  return {0.19 * shorter * std::exp(-s * (0.3 + 1.3 * s)), 0.11 * shorter * std::exp(-0.9 * s * s)};
}

/// Λ that markers leave out which stand back. @param cells ζ/h, may be below 0 in contact
/// @param diffusion_number λ
inline SlideAndRoll logarithms_left_by_markers(double cells, double diffusion_number) {
  const double s = std::max(cells, 0.0);
  return rest_of({1.33 * std::exp(-s * (1.75 + 1.5 * s)), 0.583 * std::exp(-s * (1.85 + 1.55 * s))},
                 logarithms_of_short_steps(s, diffusion_number));
}

/// What markers leave out that stand back from a wall: of the way along it, of the turning, and
/// what ties one to the other.
struct LeftAtWall {
  double way = 0, tie = 0, turn = 0;  ///< Λ_v, Λ_vω, Λ_ω
};

/// @param cells ζ/h, may be below 0 in contact  @param cell_share c = h/(2a), measured to 1/4
/// @param diffusion_number λ
inline LeftAtWall left_by_markers_at_wall(double cells, double cell_share,
                                          double diffusion_number) {
  const double s = std::max(cells, 0.0), shorter = shorter_than_longest(diffusion_number);
  const double c = std::min(cell_share, 0.25), square = c * c, fourth = square * square;
  const double resolved = shorter * std::exp(-1.2 * s * (1 + s));
  LeftAtWall left;
  left.way = std::max(0.0, 1.85 * std::exp(-s * (1.1 + 2.25 * s)) - 0.15 * resolved -
                               0.113 * shorter * std::exp(s * (1.4 - 2.5 * s)));
  left.tie = std::clamp(
      (0.39 + 11.2 * square) * std::exp(-s * (1 + 2.3 * s)) - (0.1 + 1.65 * square) * resolved, 0.0,
      left.way);
  left.turn = std::max(
      left.way > 0 ? left.tie * left.tie / left.way : 0.0,
      (0.485 + 170 * fourth) * std::exp(-s * (1.95 + 2 * s)) - (0.15 + 60 * fourth) * resolved);
  return left;
}

/// The dampers [kg/s], and the bodies that they act between.
struct TangentialFilm {
  double slide, roll;   ///< 2 π μ R Λ_s, 4.8 π μ R Λ_e
  double arm_i, arm_j;  ///< a, b to the middle of the gap [m]; arm_j is 0 at a wall
  double skew;          ///< χ
  /// 2 π μ R times Λ_v, Λ_vω and Λ_ω, of a wall
  double way = 0, tie = 0, turn = 0;
};

inline TangentialFilm tangential_film(double viscosity, double effective_radius,
                                      const SlideAndRoll& logarithms) {
  constexpr double pi = 3.14159265358979323846;
  const double strength = pi * viscosity * effective_radius;
  return {2 * strength * logarithms.slide, 4.8 * strength * logarithms.roll, 0, 0, 0};
}

/// @param viscosity μ  @param gap ζ, may be below 0 in contact  @param logarithms Λ
inline TangentialFilm tangential_film_of_pair(double viscosity, double a, double b, double gap,
                                              const SlideAndRoll& logarithms) {
  TangentialFilm film = tangential_film(viscosity, a * b / (a + b), logarithms);
  film.arm_i = a + 0.5 * gap;
  film.arm_j = b + 0.5 * gap;
  film.skew = (a - b) / (a + b + gap);
  return film;
}

/// The wall is a sphere of infinite radius that does not turn.
/// @param left what its markers leave
inline TangentialFilm tangential_film_at_wall(double viscosity, double a, double gap,
                                              const SlideAndRoll& logarithms,
                                              const LeftAtWall& left = {}) {
  TangentialFilm film = tangential_film(viscosity, a, logarithms);
  film.arm_i = a + 0.5 * gap;
  film.skew = -1;
  const double strength = tangential_film(viscosity, a, {1, 0}).slide;
  film.way = strength * left.way, film.tie = strength * left.tie, film.turn = strength * left.turn;
  return film;
}

inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Force on i (that on j is its opposite) and torques about both centres.
struct TangentialLoads {
  Vector3 force, torque_i, torque_j;
};

/// @param v velocity of i relative to j (or the wall); its part along n counts nothing [m/s]
/// @param spin_j 0 at a wall [1/s]
inline TangentialLoads tangential_loads(const TangentialFilm& film, const Vector3& n, Vector3 v,
                                        const Vector3& spin_i, const Vector3& spin_j) {
  const double along = v[0] * n[0] + v[1] * n[1] + v[2] * n[2];
  const Vector3 turn_i = cross(n, spin_i), turn_j = cross(n, spin_j);
  TangentialLoads loads;
  Vector3 on_i, on_j;  // what n x turns into the torques
  for (int d = 0; d < 3; ++d) {
    v[d] -= along * n[d];
    const double i = film.arm_i * turn_i[d], j = film.arm_j * turn_j[d];
    const double sliding = -film.slide * (v[d] + i + j);
    const double rolling = -film.roll * 0.5 * (film.skew * v[d] + i - j);
    loads.force[d] = sliding + 0.5 * film.skew * rolling - film.way * v[d] - film.tie * i;
    on_i[d] = -film.arm_i * (sliding + 0.5 * rolling - film.tie * v[d] - film.turn * i);
    on_j[d] = -film.arm_j * (sliding - 0.5 * rolling);
  }
  loads.torque_i = cross(n, on_i);
  loads.torque_j = cross(n, on_j);
  return loads;
}

/// At what rate, at most, this film alone slows down one of its spheres [1/s].
/// @param inverse_mass 1/m, 0 for one that is held  @param inverse_inertia 1/I
inline double tangential_rate(const TangentialFilm& film, double arm, double inverse_mass,
                              double inverse_inertia) {
  const double turning = arm * arm * inverse_inertia;
  return film.slide * (inverse_mass + turning) +
         0.25 * film.roll * (film.skew * film.skew * inverse_mass + turning) +
         film.way * inverse_mass + film.turn * turning;
}

/// What the dampers of a film are multiplied by in a step: the mean over the step of a motion that
/// dies away at the sum `rate` of the rates of all films of its sphere (of the two sums the
/// larger).
///     φ1(x) = (1 - e^{-x})/x,   x = 2 rate Δt
/// With it no step makes kinetic energy, however long it is: K = Σ c φ1 g gᵀ, with g = (g_i, g_j)
/// the motion by which a film's damper moves its spheres in units of their inertia, is at most Σ 2
/// c φ1 (g_i g_iᵀ + g_j g_jᵀ), in each sphere's block at most Σ 2 c |g_i|²/(2 rate Δt) = 1/Δt. And
/// 1 - φ1 ~ x/2 is nothing where x << 1, as it is in a fluid whose time step resolves its grains.
inline double tangential_step_share(double rate, double dt) {
  const double x = 2 * rate * dt;
  return x < 1e-5 ? 1 - 0.5 * x : -std::expm1(-x) / x;
}

}  // namespace bedload::contact
