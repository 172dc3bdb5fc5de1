#pragma once

#include "fluid/decomposition.hpp"
#include "fluid/field.hpp"
#include "fluid/grid.hpp"

namespace bedload {

/// Integrals and extremes of a velocity field with valid ghosts. All are collective and return the
/// same number on every rank.

/// Sum over all cells of |u|^2/2 h^3, each component at its own faces [L^5/T^2].
template <class Real>
double kinetic_energy_integral(const Field<Real>& velocity, const Grid& grid,
                               const Decomposition& slabs);

/// Largest |div u| of all cells [1/T].
template <class Real>
double largest_divergence(const Field<Real>& velocity, const Grid& grid,
                          const Decomposition& slabs);

/// Sum over all u faces of u.
template <class Real>
double streamwise_sum(const Field<Real>& velocity, const Decomposition& slabs);

/// Largest |u|+|v|+|w| [L/T] of this rank's cells alone.
template <class Real>
double largest_local_speed(const Field<Real>& velocity);

/// Global cell of the first value that is not finite on this rank.
struct BadPlace {
  bool found = false;
  int i = 0, j = 0, k = 0, component = 0;
};
template <class Real>
BadPlace find_not_finite(const Field<Real>& velocity, const Decomposition& slabs);

}  // namespace bedload
