#pragma once

#include <string>

#include "fluid/checkpoint/state_format.hpp"
#include "fluid/grid/flow_view.hpp"

namespace bedload {

/// Writes the staggered flow in the precision of its fields, with grid, time, step and driving
/// force, and what `save` adds for a run that goes on; under a temporary name until it is whole.
/// Collective; throws UserError on all ranks and leaves no half-written file.
template <class Real>
void write_state(const std::string& path, const FlowView<Real>& flow, const SaveRun& save = {});

/// Whether a state has the cells of a grid; faces that differ by round-off are the same.
bool same_cells(const StateHeader& stored, const Grid& grid);

/// What read_state() found.
struct StateRead {
  StateHeader header;
  bool interpolated = false;  ///< the grids differ: the velocity is not free of divergence
};

/// Fills this rank's own cells of `fields` from a state, compact or full: all of the list that are
/// in a restart; ghosts are left to the caller. On the same grid (cells and heights of planes) the
/// values come back bit for bit whatever the number of ranks then and now. On another grid over the
/// same box each one is interpolated linearly in the three directions on its own staggered points,
/// periodic or up to the walls of `grid`. What is not stored becomes zero. Collective; throws
/// UserError on all ranks when the file cannot be trusted or its box or its periodic directions
/// differ.
template <class Real>
StateRead read_state(const std::string& path, const Grid& grid, const Decomposition& decomposition,
                     FlowFields<Real>& fields);
/// The same from a state that is open.
template <class Real>
StateRead read_state(const StateReader& state, const Grid& grid, const Decomposition& decomposition,
                     FlowFields<Real>& fields);

/// How a compact state is made smaller.
struct Compaction {
  int every = 2;  ///< cells per stored cell along each direction; must divide the cells
  int gzip = 9;
};

/// Makes a small start field from a state: the velocity on a grid `every` times coarser, each value
/// the mean over the faces that the coarse face is made of (a flow without divergence stays one),
/// as 16-bit integers times a scale per component, deflated; without pressure and extras. The
/// rounding error is at most half of max|component| / 32767. Collective.
void write_compact_state(const std::string& state, const std::string& compact, MPI_Comm comm,
                         const Compaction& how = {});

}  // namespace bedload
