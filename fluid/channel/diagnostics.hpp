#pragma once

#include <algorithm>
#include <array>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"

namespace bedload {

/// Integrals and extremes of a velocity field with valid ghosts. All are collective and return the
/// same number on every rank.

/// Sum over all cells of |u|^2/2 times their volume, each component at its own faces [L^5/T^2].
template <class Real>
double kinetic_energy_integral(const Field<Real>& velocity, const Grid& grid,
                               const Decomposition& decomposition);

/// Sum over all cells of a . b times their volume, likewise; of own cells alone [L^5/T^2].
template <class Real>
double product_integral(const Field<Real>& a, const Field<Real>& b, const Grid& grid,
                        const Decomposition& decomposition);

/// Sum over all cells of a . L u times their volume and h^2, L the discrete Laplacian: times nu/h^2
/// the work of u's viscous force on a motion a, own cells of which are used. With a = u minus what
/// viscosity takes from the kinetic energy (and resting walls with it); moving walls give.
template <class Real>
double viscous_power_integral(const Field<Real>& a, const Field<Real>& u, const Grid& grid,
                              const Decomposition& decomposition);

/// Sum over the no-slip walls of their velocity times h times its gradient towards them, times the
/// wall's area and h: times nu/h^2 the work of walls that slide on the fluid over its density;
/// what viscosity turns into heat is this minus viscous_power_integral(u, u) [L^5/T^2].
template <class Real>
double wall_power_integral(const Field<Real>& u, const Grid& grid,
                           const Decomposition& decomposition);

/// Sum over all cells of a . N(u) times their volume and h, N = -div(uu) the discrete convection
/// (momentum.hpp) of a field free of divergence: the work of u's convection on a motion a, own
/// cells of which are used; zero with a = u.
template <class Real>
double convective_power_integral(const Field<Real>& a, const Field<Real>& u, const Grid& grid,
                                 const Decomposition& decomposition);

/// Largest |div u| of all cells [1/T].
template <class Real>
double largest_divergence(const Field<Real>& velocity, const Grid& grid,
                          const Decomposition& decomposition);

/// Sum over all u faces of u, each times the height of its cell over h.
template <class Real>
double streamwise_sum(const Field<Real>& velocity, const Grid& grid,
                      const Decomposition& decomposition);

/// Largest |u| + |v| h/dy + |w| [L/T] of this rank's cells alone, dy being the height of the lower
/// cell beside v.
template <class Real>
double largest_local_speed(const Field<Real>& velocity, const Grid& grid,
                           const Decomposition& decomposition);

/// Sum over this rank's cells beside walls of u beyond the wall minus u, times the area of the wall
/// over the distance across it: the walls' share of h^2 times the sum of the Laplacian [L/T].
template <class Real>
double local_wall_sum(const Field<Real>& velocity, const Grid& grid,
                      const Decomposition& decomposition);

/// Mean streamwise stress that a fluid of this dynamic viscosity [M/(L T)] exerts on the lower and
/// on the upper wall [M/(L T^2)].
template <class Real>
std::array<double, 2> mean_wall_stress(const Field<Real>& velocity, const Grid& grid,
                                       const Decomposition& decomposition,
                                       double dynamic_viscosity);

/// h over the height of the lower one of the cells below and above face j.
inline double stretch_at(const Grid& grid, int face) {
  return 1.0 / std::min(grid.thickness(face), grid.thickness(face + 1));
}

/// Global cell of the first value that is not finite on this rank.
struct BadPlace {
  bool found = false;
  int i = 0, j = 0, k = 0, component = 0;
};
template <class Real>
BadPlace find_not_finite(const Field<Real>& velocity, const Decomposition& decomposition);

/// Global cell with the largest |u| + |v| h/dy + |w| of all ranks. Collective.
template <class Real>
std::array<int, 3> find_fastest(const Field<Real>& velocity, const Grid& grid,
                                const Decomposition& decomposition);

}  // namespace bedload
