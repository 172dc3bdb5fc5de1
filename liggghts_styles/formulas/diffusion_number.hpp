#pragma once

#include <algorithm>
#include <cmath>

/// How much slip the fluid's markers leave where two spheres share cells, and beside a wall: the
/// films there (formulas/lubrication.hpp, formulas/tangential_lubrication.hpp) know of it by one
/// number.
namespace bedload::contact {

/// λ = ν Δt/h² / n^1.3, n loops of the forcing in a step: they leave as little slip as one loop in
/// a step so much shorter. Measured by the forces and torques on two spheres at gaps of 0.002 to 1
/// h, two and four loops at ν Δt/h² = 0.0125 to 0.2 (powers of 1.1 to 1.4, and 1.9 for two loops at
/// 0.2; `./bedload study validation film sliding`).
inline double diffusion_number_of_loop(double diffusion_number, double forcing_loops) {
  return diffusion_number / std::pow(forcing_loops, 1.3);
}

/// The range in which films against sliding and rolling were measured, and its end beyond it: 0.2
/// is the limit of explicit diffusion.
inline constexpr double shortest_diffusion_number = 0.003, longest_diffusion_number = 0.2;
inline double measured_diffusion_number(double diffusion_number) {
  return std::clamp(diffusion_number, shortest_diffusion_number, longest_diffusion_number);
}

/// λ of films along the line of centres, which were measured in steps of implicit diffusion, too:
/// markers keep a force from step to step there (fluid/immersed_boundary/marker_force.hpp), which
/// closes within some tens of steps what a long step leaves. With
///     max(0.2, λ^1.5/2) of λ above 0.2, at most 8,
/// grid and film together are within 4 % of the exact force of two spheres at gaps of 0.1 to 1 h
/// 40 steps after they set off at once with λ = 1 to 4, within 9 % with 7.2 (1 % after 100), and
/// within 5 % at walls.
inline double diffusion_number_of_approach(double diffusion_number) {
  constexpr double longest = 8;
  if (diffusion_number <= longest_diffusion_number)
    return measured_diffusion_number(diffusion_number);
  return std::clamp(0.5 * std::pow(diffusion_number, 1.5), longest_diffusion_number, longest);
}

/// λ where it is not known, as without a fluid.
inline constexpr double usual_diffusion_number = 0.05;

}  // namespace bedload::contact
