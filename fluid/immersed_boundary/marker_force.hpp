#pragma once

#include <algorithm>

namespace bedload {

/// The force that implicit diffusion knows of.
///
/// The markers act behind a stage's diffusion. Implicit diffusion has smoothed what they imposed
/// over sqrt(nu dt) by then, and what they take from the slip of their own cells is less than the
/// drag: the surface slips as if nu dt/h^2 cells deep. So each marker keeps a force f per time that
/// stands on the right side of the Helmholtz equation, and gives the rest as before:
///
///   (1 - after dt nu L) u* = ... + 2 alpha_k dt J^T f,      u = u* + J^T V (U - J u*),
///   f <- share f + gain V (U - J u*)/dt.
///
/// In a steady flow f is the whole force, and u is that of explicit diffusion. It is an integral
/// controller beside the proportional one. With a large gain a free sphere swings against its
/// fluid: close to others, where the drag of a step is many times the fluid that a marker moves, it
/// has little damping, and a torque that comes in shares none. With twice this gain the spheres of
/// the tests DenseFreeSpheresCalmDownInLongSteps and LightSphereTurnsCalmlyInLongSteps do not calm
/// down.
constexpr double marker_force_gain = 0.3;

/// Share of f that stays from stage to stage. What the smooth part of the force lacks is
/// (1 - share)/gain nu dt/h^2 of a cell's slip; short waves, which explicit forcing leaves alone
/// for the most part, would add up if nothing went. With a hundredth of a cell a stage an array's
/// drag is within 1.4 % of that of explicit diffusion from nu dt/h^2 = 0.2 to 30, 0.4 % up to 7.2
/// where it is loose (`./bedload study validation implicit_step`).
/// @param diffusion_number nu dt/h^2, dt the whole step's
inline double marker_force_share(double diffusion_number) {
  constexpr double slip = 0.01;  // [cells]
  return std::max(0.0, 1.0 - slip * marker_force_gain / diffusion_number);
}

}  // namespace bedload
