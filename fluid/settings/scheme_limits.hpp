#pragma once

namespace bedload {

/// Stability of the time stepping on the axes of the complex plane: |omega dt| for pure convection,
/// |lambda dt| for pure diffusion (of any third-order three-stage scheme: 1 + z + z^2/2 + z^3/6).
inline constexpr double imaginary_limit = 1.7320508075688772;
inline constexpr double real_limit = 2.5127453266183286;

}  // namespace bedload
