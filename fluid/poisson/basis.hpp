#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>

#include "fluid/grid/grid.hpp"

namespace bedload {

/// The functions of one direction in which second differences are diagonal, given by what happens
/// at its ends. n cells; all but `faces` live on cell centres j = 0 .. n-1:
///
///   periodic    exp(2 pi i k j/n)                      Fourier transform
///   even_even   cos(pi k (j+1/2)/n)                    zero gradient at both walls (DCT-II)
///   odd_odd     sin(pi (k+1) (j+1/2)/n)                zero at both walls (DST-II)
///   even_odd    cos(pi (k+1/2) (j+1/2)/n)              zero gradient below, zero above (DCT-IV)
///   odd_even    sin(pi (k+1/2) (j+1/2)/n)              zero below, zero gradient above (DST-IV)
///   faces       sin(pi (k+1) (j+1)/n), j = 0 .. n-2    the component normal to the walls, on the
///                                                      upper faces; the last one is a wall (DST-I)
///
/// (Martucci, IEEE Trans. Signal Process. 42 (1994) 1038; FFTW manual, 1d real-even/odd DFTs.)
enum class Basis { periodic, even_even, odd_odd, even_odd, odd_even, faces };

/// What is transformed: a velocity component, or the pressure.
inline constexpr int pressure_component = 3;

inline Basis basis_of(const Grid& grid, int component, int direction) {
  const auto& ends = grid.walls[static_cast<std::size_t>(direction)];
  if (ends[0] == Wall::periodic) return Basis::periodic;
  if (component == pressure_component) return Basis::even_even;
  if (component == direction) return Basis::faces;
  const bool odd_below = ends[0] == Wall::no_slip, odd_above = ends[1] == Wall::no_slip;
  if (odd_below) return odd_above ? Basis::odd_odd : Basis::odd_even;
  return odd_above ? Basis::even_odd : Basis::even_even;
}

/// Eigenvalue of q_j-1 - 2 q_j + q_j+1 for function k of n cells: 2 cos(theta) - 2, theta the phase
/// from one cell to the next.
inline double second_difference(Basis basis, int k, int n) {
  const double half_turns = basis == Basis::periodic                               ? 2.0 * k
                            : basis == Basis::even_even                            ? k
                            : basis == Basis::even_odd || basis == Basis::odd_even ? k + 0.5
                                                                                   : k + 1.0;
  const double s = std::sin(0.5 * std::numbers::pi * half_turns / n);
  return -4.0 * s * s;
}

}  // namespace bedload
