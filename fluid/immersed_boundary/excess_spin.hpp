#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fluid/grid/sphere.hpp"

namespace bedload {

/// (R/R_t)^3 - 1, R_t the radius at which markers with the retraction that is right for drag hold
/// the fluid as far as torque goes: by how much the torque on a sphere that turns in Stokes flow is
/// too small, all in cells:
///
///   (1/R)^2 + 0.31 (r/R)^2/R.
///
/// The first term is of second order, as the curvature of a surface in cells is. The second belongs
/// to a rigid core of radius r: markers that it lets lie 0.13 (r/R)^2 deeper (marker_layout.hpp)
/// lose three times that over R, of which it gives back a fifth. Both coefficients are what
/// `./bedload study validation rotation` finds at D/h = 8 to 24.
inline double torque_deficit(double radius_in_cells, double core_in_cells) {
  const double share = core_in_cells / radius_in_cells;
  return (1.0 / radius_in_cells + 0.31 * share * share) / radius_in_cells;
}

/// How far the markers' rotation runs ahead of their sphere's.
///
/// The fluid meets a sphere that turns as if its surface lay at R_t < R. In the shear of the torque
/// T between both radii the fluid's rotation drops by
///
///   delta omega = -gamma T/(8 pi mu R^3),    gamma = (R/R_t)^3 - 1,
///
/// T on the sphere by the fluid (at R, 8 pi mu R^3 omega is the stress of a turning sphere in any
/// flow), and by so much faster the markers turn. A sphere without torque, one that is carried by
/// shear or falls freely, keeps its spin. Markers that turn faster at once make a torque, whatever
/// the viscosity, which would ask for more: so the excess follows the torque in the time that
/// viscosity takes for a cell, h^2/nu, in which that torque is some per cent of what asked for it.
///
/// @param torque T/rho_f, mean of the stage [L^5/T^2]  @param viscosity nu [L^2/T]
/// @param stage_step [T]
/// @return the excess of the next stage [1/T]
inline Vec3 next_excess_spin(const Vec3& excess, const Vec3& torque, double radius, double core,
                             double h, double viscosity, double stage_step) {
  const double rate = stage_step / (h * h);  // per viscosity
  const double share = std::min(1.0, rate * viscosity);
  const double share_over_viscosity = std::min(1.0 / viscosity, rate);
  const double stress = 8.0 * std::numbers::pi * std::pow(radius, 3);
  return (1.0 - share) * excess -
         share_over_viscosity * torque_deficit(radius / h, core / h) / stress * torque;
}

}  // namespace bedload
