#pragma once

#include <cstdint>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field_list.hpp"
#include "fluid/grid/grid.hpp"

namespace bedload {

/// What the writers see of a flow: its fields on this rank's planes, and where it stands in time.
template <class Real>
struct FlowView {
  const Grid& grid;
  const Decomposition& decomposition;
  const FlowFields<Real>& fields;  ///< lower ghosts (i, j, k = -1) of the velocity valid
  double time;                     ///< [T]
  std::int64_t step;
  double driving;  ///< mean driving force per volume along x [M/(L^2 T^2)]
  const Field<Real>& velocity = fields[Stored::velocity];  ///< staggered u, v, w [L/T]
  const Field<Real>& pressure = fields[Stored::pressure];  ///< kinematic, p / rho [L^2/T^2]
};

/// The view of a solver that has these accessors (Channel).
template <template <class> class Solver, class Real>
FlowView<Real> view_of(const Solver<Real>& solver) {
  return {solver.grid(), solver.decomposition(), solver.fields(),
          solver.time(), solver.step(),          solver.driving_force()};
}

}  // namespace bedload
