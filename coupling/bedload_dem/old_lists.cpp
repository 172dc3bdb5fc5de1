#include "coupling/bedload_dem/old_lists.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>

#include "atom.h"
#include "comm.h"
#include "coupling/bedload_dem/over_ranks.hpp"
#include "error.h"
#include "fluid/grid/sphere.hpp"
#include "force.h"
#include "neighbor.h"

namespace bedload {

void OldLists::look(double fluid_time_step) {
  if (told_ || force->pair == nullptr || !outlived(fluid_time_step)) return;
  told_ = true;
  if (comm->me != 0) return;
  error->warning(
      FLERR, fmt::format("coupled_run: spheres move more than half the skin ({:g}) before the "
                         "neighbour lists are built anew (neigh_modify every {}, delay {}, check "
                         "{}), so that contacts may be missed; write 'neigh_modify every 1 delay "
                         "0 check yes once no'",
                         neighbor->skin, neighbor->every, neighbor->delay,
                         neighbor->dist_check ? "yes" : "no")
                 .c_str());
}

// With `check yes` LIGGGHTS knows where each sphere was at the last build, and builds lists as soon
// as one has moved half a skin and `every` and `delay` let it: a fluid step later they are new.
// With `check no` it is the sum of the largest speeds, way = Σ max|v| Δt.
bool OldLists::outlived(double fluid_time_step) {
  const bool before = moved_far_;
  const bool fresh = neighbor->lastcall != built_at_;
  built_at_ = neighbor->lastcall;
  moved_far_ = false;
  if (fresh) {
    way_ = 0.0;
    return false;
  }
  if (neighbor->dist_check == 0) {
    way_ += largest_speed() * fluid_time_step;
    return way_ > 0.5 * neighbor->skin;
  }
  moved_far_ = neighbor->check_distance() != 0;
  return before && moved_far_;
}

double OldLists::largest_speed() const {
  double largest = 0.0;
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, Vec3(atom->v[i]).norm());
  return reduced(largest, MPI_DOUBLE, MPI_MAX, world);
}

}  // namespace bedload
