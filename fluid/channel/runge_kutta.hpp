#pragma once

#include <array>

#include "fluid/settings/scheme_limits.hpp"

namespace bedload {

/// Low-storage Runge-Kutta scheme of third order for the explicit terms,
///
///   u_k = u_{k-1} + dt (gamma_k N(u_{k-1}) + zeta_k N(u_{k-2})) - 2 alpha_k dt grad p,
///
/// 2 alpha_k = gamma_k + zeta_k being the part of the step that stage k covers. A. Wray's
/// coefficients as used by Rai & Moin, J. Comput. Phys. 96 (1991) 15, and by Uhlmann,
/// J. Comput. Phys. 209 (2005) 448, eq. (8).
///
/// Implicit diffusion leaves the tendency N to convection and adds dt nu L (before_k u_k-1 +
/// after_k u_k), before_k + after_k = 2 alpha_k: Spalart, Moser & Rogers, J. Comput. Phys. 96
/// (1991) 297, eq. (A2). Stable for any nu; second order in time. A wave too short to be resolved
/// in time is damped by 0.47 in a step (by -1 with before = after, Crank-Nicolson).
struct Stage {
  double gamma;      ///< weight of the present tendency
  double zeta;       ///< weight of the tendency of the stage before
  double two_alpha;  ///< share of the time step
  double before;     ///< weight of diffusion at the begin of the stage, if implicit
  double after;      ///< weight of diffusion at its end, if implicit
};

inline constexpr int stage_count = 3;
inline constexpr std::array<Stage, stage_count> runge_kutta{{
    {8.0 / 15.0, 0.0, 8.0 / 15.0, 29.0 / 96.0, 37.0 / 160.0},
    {5.0 / 12.0, -17.0 / 60.0, 2.0 / 15.0, -3.0 / 40.0, 5.0 / 24.0},
    {3.0 / 4.0, -5.0 / 12.0, 1.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0},
}};

}  // namespace bedload
