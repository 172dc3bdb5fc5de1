#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

/// Calibration of the adaptive collision time model (ACTM), done once per material pair.
///
/// Paper: T. Kempe, J. Fröhlich, "Collision modelling for the interface-resolved simulation of
/// spherical particles in viscous fluids", J. Fluid Mech. 709 (2012), eqs. (4.2)-(4.7); the closed
/// form is S. Ray, T. Kempe, J. Fröhlich, "Efficient modelling of particle collisions using a
/// non-linear viscoelastic contact force", Int. J. Multiphase Flow 76 (2015).
///
/// A dry head-on collision obeys m δ'' + d δ' + k δ^{3/2} = 0 with overlap δ, δ(0) = 0 and
/// δ'(0) = u_in. With the time unit t*, the length unit u_in t* and
///     d = 2 λ m / t*,   k = m / sqrt(u_in t*^5)
/// it becomes  x'' + 2 λ x' + x^{3/2} = 0, x(0) = 0, x'(0) = 1, with the single parameter λ. Hence
/// the restitution e = -x'(τ) and the duration τ = T_c / t* are functions of λ alone, and inverting
/// e(λ) once leaves nothing to be solved in a collision.
///
/// Symbols: λ damping parameter [-], τ duration in units of t* [-], e restitution [-].
/// Valid range: 0 < e <= 1. τ grows without bound as e -> 0; e below minimum_restitution is
/// refused.
namespace bedload::contact {

/// Smallest restitution coefficient that the calibration accepts. [-]
inline constexpr double minimum_restitution = 0.01;

/// What one dimensionless dry collision does.
struct DryCollision {
  double restitution;      ///< rebound speed over impact speed [-]; 0 when it never separates
  double duration;         ///< τ, in units of t* [-]
  double largest_overlap;  ///< in units of u_in t* [-]
};

/// Parameters that make a collision rebound with e and last T_c.
struct ActmCalibration {
  double lambda;               ///< λ [-]
  double tau;                  ///< τ = T_c / t* [-]
  double largest_overlap = 0;  ///< X, in units of u t* [-]
};

namespace detail {

/// State of the dimensionless collision: overlap (or its root), velocity, time.
struct CollisionState {
  double x, y, t;
};

/// One classical fourth-order Runge-Kutta step of `rate` (a function State -> State) of length h.
template <class Rate>
CollisionState runge_kutta4(const CollisionState& a, double h, Rate rate) {
  const auto along = [](const CollisionState& p, double c, const CollisionState& q) {
    return CollisionState{p.x + c * q.x, p.y + c * q.y, p.t + c * q.t};
  };
  const CollisionState k1 = rate(a);
  const CollisionState k2 = rate(along(a, 0.5 * h, k1));
  const CollisionState k3 = rate(along(a, 0.5 * h, k2));
  const CollisionState k4 = rate(along(a, h, k3));
  return {a.x + h / 6 * (k1.x + 2 * k2.x + 2 * k3.x + k4.x),
          a.y + h / 6 * (k1.y + 2 * k2.y + 2 * k3.y + k4.y),
          a.t + h / 6 * (k1.t + 2 * k2.t + 2 * k3.t + k4.t)};
}

}  // namespace detail

/// Solves x'' + 2 λ x' + x^{3/2} = 0, x(0) = 0, x'(0) = 1 until x = 0 again.
///
/// The right-hand side is not smooth at x = 0. Near both ends the root s = sqrt(x) is therefore the
/// independent variable (dy/ds = 2 s (-2 λ - s³/y), dt/ds = 2 s / y: smooth), and time only in
/// between. @param lambda λ >= 0 [-]  @param steps steps in each of the three pieces; 2000 reach
/// round-off.
inline DryCollision dry_collision(double lambda, int steps = 2000) {
  using detail::CollisionState;
  // Independent variable s; the slot x carries s itself.
  const auto along_root = [lambda](const CollisionState& c) {
    const double s = c.x;
    return CollisionState{1.0, 2 * s * (-2 * lambda - s * s * s / c.y), 2 * s / c.y};
  };
  const auto along_time = [lambda](const CollisionState& c) {
    return CollisionState{c.y, -2 * lambda * c.y - c.x * std::sqrt(c.x), 1.0};
  };

  // Loading: x up to a value that is still well below the turning point x ~ 1/(1 + 2λ).
  const double s_load = std::sqrt(0.4 / (1 + 2 * lambda));
  CollisionState c{0.0, 1.0, 0.0};
  for (int n = 0; n < steps; ++n) {
    c = detail::runge_kutta4(c, s_load / steps, along_root);
  }

  // Turning: in time, until half of the largest overlap is left.
  c.x = s_load * s_load;
  double largest = c.x;
  const double h = 3.0 / steps;
  while (c.y > 0 || c.x > 0.5 * largest) {
    c = detail::runge_kutta4(c, h, along_time);
    largest = std::max(largest, c.x);
    if (c.t > 50) return {0.0, c.t, largest};  // creeps back, never separates
  }

  // Unloading: down to s = 0. Where the damping stops the return (y = 0) there is no rebound.
  const double s_unload = std::sqrt(c.x);
  c.x = s_unload;
  for (int n = 0; n < steps; ++n) {
    c = detail::runge_kutta4(c, -s_unload / steps, along_root);
    if (!(c.y < 0)) return {0.0, c.t, largest};
  }
  return {-c.y, c.t, largest};
}

/// Inverts e(λ) to round-off (secant steps kept inside a bracket) and returns λ, τ and X.
/// @param restitution e_dry, minimum_restitution <= e <= 1 [-]
/// @throws std::invalid_argument outside that range.
inline ActmCalibration calibrate_actm(double restitution) {
  if (!(restitution >= minimum_restitution && restitution <= 1)) {
    throw std::invalid_argument("restitution coefficient outside its range");
  }
  const auto calibrated = [](double lambda) {
    const DryCollision found = dry_collision(lambda);
    return ActmCalibration{lambda, found.duration, found.largest_overlap};
  };
  if (restitution == 1) return calibrated(0.0);
  // e(λ) falls monotonically from 1 and reaches 0 near λ = 0.57.
  double lower = 0.0, upper = 0.7;
  double f_lower = 1 - restitution, f_upper = -restitution;
  double lambda = 0.0;
  int side = 0;
  for (int n = 0; n < 200; ++n) {
    // False position with halving of the stale end (Illinois), bisection as long as e(upper) = 0.
    lambda = f_upper <= -restitution ? 0.5 * (lower + upper)
                                     : (lower * f_upper - upper * f_lower) / (f_upper - f_lower);
    const double f = dry_collision(lambda).restitution - restitution;
    if (f == 0 || upper - lower < 4e-16 * upper) break;
    if (f > 0) {
      lower = lambda;
      f_lower = f;
      if (side == 1) f_upper *= 0.5;
      side = 1;
    } else {
      upper = lambda;
      f_upper = f;
      if (side == -1) f_lower *= 0.5;
      side = -1;
    }
    if (std::abs(f) < 1e-15) break;
  }
  return calibrated(lambda);
}

/// Closed form of Ray, Kempe and Fröhlich (2015) for the same two numbers, for comparison: with
/// η = ln² e,  λ = (-C η/2 + sqrt(C² η²/4 + α² τ0² η)) / (α² τ0²),  τ = τ0 / sqrt(1 - A λ - B λ²).
/// Stated error of the rebound speed: 1.3 % for e > 0.7, 3 % for e > 0.4.
inline ActmCalibration ray_closed_form(double restitution) {
  constexpr double A = 0.716, B = 0.830, C = 0.744, alpha = 1.111, tau0 = 3.218;
  const double eta = std::log(restitution) * std::log(restitution);
  const double at2 = alpha * alpha * tau0 * tau0;
  const double lambda = (-0.5 * C * eta + std::sqrt(0.25 * C * C * eta * eta + at2 * eta)) / at2;
  return {lambda, tau0 / std::sqrt(1 - A * lambda - B * lambda * lambda)};
}

}  // namespace bedload::contact
