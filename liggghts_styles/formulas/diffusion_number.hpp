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

/// The range in which films were measured, and its end beyond it: 0.2 is the limit of explicit
/// diffusion.
inline constexpr double shortest_diffusion_number = 0.003, longest_diffusion_number = 0.2;
inline double measured_diffusion_number(double diffusion_number) {
  return std::clamp(diffusion_number, shortest_diffusion_number, longest_diffusion_number);
}

/// λ where it is not known, as without a fluid.
inline constexpr double usual_diffusion_number = 0.05;

}  // namespace bedload::contact
