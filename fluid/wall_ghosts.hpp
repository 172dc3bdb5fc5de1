#pragma once

#include "fluid/decomposition.hpp"
#include "fluid/field.hpp"
#include "fluid/grid.hpp"

namespace bedload {

/// Fills the ghost planes beyond the y walls so that the plain difference across a wall is the
/// right one: u and w have the wall's velocity as the mean of both sides (no slip) or equal values
/// (free slip); v is zero on the wall face and odd about it.
///
/// The lower wall's face is v of plane -1, the upper wall's is v of the last plane.
template <class Real>
void fill_wall_ghosts(Field<Real>& velocity, const Grid& grid, const Decomposition& slabs) {
  const int nx = velocity.nx(), nz = velocity.nz(), top = velocity.planes() - 1;
  const auto mirror = [&](int ghost, int inner, int end) {
    const bool no_slip = grid.walls[1][static_cast<std::size_t>(end)] == Wall::no_slip;
    for (int k = 0; k < nz; ++k)
      for (const int c : {0, 2}) {
        const auto& wall_velocity = grid.y_wall_velocity[static_cast<std::size_t>(end)];
        const Real twice_wall =
            no_slip ? static_cast<Real>(2.0 * wall_velocity[static_cast<std::size_t>(c)]) : Real(0);
        const Real sign = no_slip ? Real(-1) : Real(1);
        const Real* from = velocity.row(inner, k, c);
        Real* to = velocity.row(ghost, k, c);
        for (int i = -1; i <= nx; ++i) to[i] = twice_wall + sign * from[i];
      }
  };
  if (slabs.at_lower_wall()) {
    mirror(-1, 0, 0);
    for (int k = 0; k < nz; ++k) std::fill_n(velocity.row(-1, k, 1) - 1, nx + 2, Real(0));
  }
  if (slabs.at_upper_wall()) {
    mirror(top + 1, top, 1);
    for (int k = 0; k < nz; ++k) {
      std::fill_n(velocity.row(top, k, 1) - 1, nx + 2, Real(0));
      const Real* below = velocity.row(top - 1, k, 1);
      Real* ghost = velocity.row(top + 1, k, 1);
      for (int i = -1; i <= nx; ++i) ghost[i] = -below[i];
    }
  }
}

}  // namespace bedload
