#pragma once

#include <mpi.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "atom.h"
#include "lammps.h"

namespace bedload {

/// One value of each rank of `world`, put together by `operation`. Collective.
template <class T>
T reduced(T value, MPI_Datatype type, MPI_Op operation, MPI_Comm world) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, type, operation, world);
  return value;
}

/// Lowest tag of the atoms on all ranks for which holds(i), i being the place among those that a
/// rank owns; nothing: it holds for none. Collective.
template <class Condition>
std::optional<int> lowest_tag(const LAMMPS_NS::LAMMPS& lmp, Condition holds) {
  constexpr int none = std::numeric_limits<int>::max();
  int lowest = none;
  for (int i = 0; i < lmp.atom->nlocal; ++i)
    if (holds(i)) lowest = std::min(lowest, lmp.atom->tag[i]);
  lowest = reduced(lowest, MPI_INT, MPI_MIN, lmp.world);
  return lowest == none ? std::nullopt : std::optional(lowest);
}

}  // namespace bedload
