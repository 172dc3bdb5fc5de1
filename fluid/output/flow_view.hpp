#pragma once

#include <cstdint>

#include "fluid/decomposition.hpp"
#include "fluid/field.hpp"
#include "fluid/grid.hpp"

namespace bedload {

/// What the writers see of a flow: its fields on this rank's planes, and where it stands in time.
template <class Real>
struct FlowView {
  const Grid& grid;
  const Decomposition& slabs;
  const Field<Real>& velocity;  ///< staggered u, v, w [L/T]; lower ghosts (i, j, k = -1) valid
  const Field<Real>& pressure;  ///< kinematic, p / rho [L^2/T^2]
  double time;                  ///< [T]
  std::int64_t step;
  double driving;  ///< mean driving force per volume along x [M/(L^2 T^2)]
};

/// The view of a solver that has these accessors (Channel).
template <template <class> class Solver, class Real>
FlowView<Real> view_of(const Solver<Real>& solver) {
  return {solver.grid(), solver.decomposition(), solver.velocity(),     solver.pressure(),
          solver.time(), solver.step(),          solver.driving_force()};
}

}  // namespace bedload
