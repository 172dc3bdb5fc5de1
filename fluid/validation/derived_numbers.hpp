#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "fluid/grid/grid.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// Dimensionless numbers of an open-channel flow over spheres, as Vowinckel, Kempe & Froehlich
/// define them ("Impact of collision models on particle transport in open channel flow").

/// Re_b = u_b H / nu
constexpr double bulk_reynolds(double velocity, double height, double viscosity) {
  return velocity * height / viscosity;
}

/// Re_tau = u_tau H / nu; with a diameter in place of the depth D+, with a cell's edge h+.
constexpr double friction_reynolds(double u_tau, double length, double viscosity) {
  return u_tau * length / viscosity;
}

/// Fr = (rho_p - rho_f) g H / (rho_f u_b^2)
constexpr double froude(double sphere_density, double density, double gravity, double height,
                        double velocity) {
  return (sphere_density - density) * gravity * height / (density * velocity * velocity);
}

/// S = u_tau^2 rho_f / ((rho_p - rho_f) g D)
constexpr double shields(double u_tau, double density, double sphere_density, double gravity,
                         double diameter) {
  return u_tau * u_tau * density / ((sphere_density - density) * gravity * diameter);
}

/// Re = u D / nu of a sphere that falls freely and steadily: weight and drag of Schiller and
/// Naumann (1933), 18 Re (1 + 0.15 Re^0.687) = Ga^2 with Ga^2 = |rho_p/rho_f - 1| g D^3 / nu^2.
inline double falling_reynolds(double density_ratio, double gravity, double diameter,
                               double viscosity) {
  const double galileo_squared = std::abs(density_ratio - 1.0) * gravity * diameter * diameter *
                                 diameter / (viscosity * viscosity);
  double re = 0.0;
  for (int n = 0; n < 60; ++n)  // falls by half of its error or faster
    re = 0.5 * (re + galileo_squared / (18.0 * (1.0 + 0.15 * std::pow(re, 0.687))));
  return re;
}

/// Cells in the boundary layer D/sqrt(Re) of a sphere.
inline double cells_per_layer(double cells_per_diameter, double reynolds) {
  return cells_per_diameter / std::sqrt(reynolds);
}

/// u dt / h
constexpr double courant(double velocity, double time_step, double h) {
  return velocity * time_step / h;
}

/// nu dt / h^2
constexpr double diffusion_number(double viscosity, double time_step, double h) {
  return viscosity * time_step / (h * h);
}

/// u_tau that balances a driving force G per volume:  rho u_tau^2 = G H, between two no-slip walls
/// G times half of their distance (Settings::driven_height).
inline double u_tau_of_driving(double driving, const Settings& s) {
  return std::sqrt(std::abs(driving) * s.driven_height() / s.fluid.density);
}

/// u_tau of turbulent flow over a smooth wall, Dean (J. Fluids Eng. 100, 1978, 215):
/// 2 u_tau^2 / u_b^2 = 0.073 (2 H u_b / nu)^(-1/4), H being half of the distance between two walls.
/// A bed of spheres is rougher: a lower estimate.
inline double u_tau_smooth_wall(double velocity, double height, double viscosity) {
  return velocity *
         std::sqrt(0.0365 * std::pow(2.0 * bulk_reynolds(velocity, height, viscosity), -0.25));
}

/// u_tau at the wall of laminar flow with the mean velocity u_b over the height H from there to
/// where no stress is, a free surface or the middle between two walls: u_tau^2 = 3 nu u_b/H.
inline double u_tau_laminar(double velocity, double height, double viscosity) {
  return std::sqrt(3.0 * viscosity * std::abs(velocity) / height);
}

/// u_tau of laminar flow between walls at a distance that slide past each other:
/// u_tau^2 = nu |difference of their velocities|/distance.
inline double u_tau_sheared(const std::array<double, 3>& lower, const std::array<double, 3>& upper,
                            double distance, double viscosity) {
  const double difference =
      std::hypot(upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]);
  return std::sqrt(viscosity * difference / distance);
}

/// Whether a wall along z takes a part of what drives the flow.
inline bool has_side_walls(const Settings& s) {
  return s.boundary.z[0] == Wall::no_slip || s.boundary.z[1] == Wall::no_slip;
}

/// Where u_tau was taken from.
enum class FrictionSource { driving, laminar, smooth_wall };

/// The friction at the bed, and lengths in units of nu/u_tau.
struct Friction {
  FrictionSource source = FrictionSource::driving;
  double u_tau = 0.0;                ///< [L/T]
  double reynolds = 0.0;             ///< Re_tau
  double diameter_wall_units = 0.0;  ///< D+
  double cell_wall_units = 0.0;      ///< of the height of the cells beside the wall
};

/// That of a constant driving force; else that of laminar flow or of turbulent flow over a smooth
/// wall, whichever is larger (they meet at Re_b = 450, between two walls with half of their
/// distance); of walls that slide, the laminar one. None where no wall holds a flow back, nor
/// where side walls bear a part that is not known.
inline std::optional<Friction> friction_of(const Settings& s) {
  const double velocity = s.reference.velocity, height = s.driven_height();
  const double viscosity = s.fluid.kinematic_viscosity;
  const auto& [lower, upper] = s.boundary.y;
  const int beside_wall = lower == Wall::no_slip ? 0 : s.grid.cells[1] - 1;
  const double cell = s.grid.length[0] / s.grid.cells[0] * make_grid(s).thickness(beside_wall);
  const auto friction = [&](FrictionSource source, double u_tau) {
    return Friction{
        .source = source,
        .u_tau = u_tau,
        .reynolds = friction_reynolds(u_tau, s.reference.height, viscosity),
        .diameter_wall_units = friction_reynolds(u_tau, s.reference.diameter, viscosity),
        .cell_wall_units = friction_reynolds(u_tau, cell, viscosity)};
  };
  if (lower != Wall::no_slip && upper != Wall::no_slip) return std::nullopt;
  if (has_side_walls(s)) return std::nullopt;
  if (s.flow.driving == Driving::pressure_gradient || s.flow.driving == Driving::gravity)
    return friction(FrictionSource::driving, u_tau_of_driving(s.constant_driving(), s));
  const bool two_walls = lower == Wall::no_slip && upper == Wall::no_slip;
  if (s.flow.driving == Driving::none) {
    const double sheared = u_tau_sheared(s.boundary.y_lower_velocity, s.boundary.y_upper_velocity,
                                         s.grid.length[1], viscosity);
    if (!two_walls || sheared == 0.0) return std::nullopt;
    return friction(FrictionSource::laminar, sheared);
  }
  const double laminar = u_tau_laminar(velocity, height, viscosity);
  const double turbulent = u_tau_smooth_wall(velocity, height, viscosity);
  return laminar > turbulent ? friction(FrictionSource::laminar, laminar)
                             : friction(FrictionSource::smooth_wall, turbulent);
}

/// The numbers of one scene; those without a value do not apply to it (no spheres, no gravity).
struct DerivedNumbers {
  double cell = 0.0;              ///< h [L]
  double reynolds_bulk = 0.0;     ///< Re_b
  double cells_per_diameter = 0;  ///< D/h
  double cfl_at_start = 0.0;      ///< u_b dt/h
  double diffusion = 0.0;         ///< nu dt/h^2
  std::optional<Friction> friction;
  std::optional<double> density_ratio;     ///< rho_p / rho_f
  std::optional<double> froude;            ///< Fr
  std::optional<double> shields;           ///< S
  std::optional<double> falling_reynolds;  ///< of a sphere that falls freely
  std::optional<double> cells_per_layer;   ///< in its boundary layer
};

/// All numbers that follow from the settings, with u_b, H, D and rho_p from reference.*.
inline DerivedNumbers derive_numbers(const Settings& s) {
  const auto& [velocity, height, diameter, sphere_density] = s.reference;
  const double viscosity = s.fluid.kinematic_viscosity;
  DerivedNumbers n;
  n.cell = s.grid.length[0] / s.grid.cells[0];
  n.reynolds_bulk = bulk_reynolds(velocity, height, viscosity);
  n.cells_per_diameter = diameter / n.cell;
  n.cfl_at_start = courant(velocity, s.time.step, n.cell);
  n.diffusion = diffusion_number(viscosity, s.time.step, n.cell);
  n.friction = friction_of(s);
  const double gravity = std::hypot(s.fluid.gravity[0], s.fluid.gravity[1], s.fluid.gravity[2]);
  if (sphere_density > 0.0) n.density_ratio = sphere_density / s.fluid.density;
  if (sphere_density > s.fluid.density && gravity > 0.0) {
    n.froude = froude(sphere_density, s.fluid.density, gravity, height, velocity);
    if (n.friction)
      n.shields = shields(n.friction->u_tau, s.fluid.density, sphere_density, gravity, diameter);
    n.falling_reynolds = falling_reynolds(*n.density_ratio, gravity, diameter, viscosity);
    n.cells_per_layer = cells_per_layer(n.cells_per_diameter, *n.falling_reynolds);
  }
  return n;
}

}  // namespace bedload
