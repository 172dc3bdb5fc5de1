#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "fluid/field.hpp"
#include "fluid/grid.hpp"

namespace bedload {

/// First plane of each slab, and behind the last one the number of planes: `parts` slabs of at
/// least one plane whose costs are as even as whole planes allow. `cost` holds one number per
/// plane. Throws UserError when there are more parts than planes.
std::vector<int> divide_planes(std::span<const double> cost, int parts);

/// How the y planes are dealt out to the ranks of a communicator: slab r holds the planes first(r)
/// to first(r+1)-1, in the order of the ranks. Local plane j of a field is global plane first() +
/// j.
class Decomposition {
 public:
  /// `plane_cost` (global planes) steers the division; empty: all planes cost the same.
  Decomposition(const Grid& grid, MPI_Comm comm, std::span<const double> plane_cost = {});

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  int ranks() const { return static_cast<int>(first_.size()) - 1; }

  int first() const { return first(rank_); }
  int planes() const { return planes(rank_); }
  int first(int rank) const { return first_[static_cast<std::size_t>(rank)]; }
  int planes(int rank) const { return first(rank + 1) - first(rank); }
  /// Rank that holds a global plane.
  int owner(int global_plane) const;
  /// Whether a global plane is one of this rank's own.
  bool holds(int global_plane) const {
    return global_plane >= first() && global_plane < first() + planes();
  }

  /// Neighbouring ranks, MPI_PROC_NULL beyond a wall; the rank itself where periodic y closes on
  /// it.
  int below() const { return below_; }
  int above() const { return above_; }
  bool at_lower_wall() const { return below_ == MPI_PROC_NULL; }
  bool at_upper_wall() const { return above_ == MPI_PROC_NULL; }

  /// Fills the ghost planes -1 and planes() with the neighbours' edge planes, x ghosts included.
  /// Ghost planes beyond a wall are left alone. Collective.
  template <class Real>
  void exchange(Field<Real>& field) const;

  /// The reverse: adds the ghost planes to the planes of the neighbours that they stand for and
  /// empties them; x ghosts are folded in first. Ghost planes beyond a wall are left alone.
  /// Collective.
  template <class Real>
  void add_ghosts(Field<Real>& field) const;

 private:
  MPI_Comm comm_;
  int rank_ = 0;
  int below_ = MPI_PROC_NULL, above_ = MPI_PROC_NULL;
  std::vector<int> first_;
};

template <class Real>
MPI_Datatype mpi_type();
template <>
inline MPI_Datatype mpi_type<double>() {
  return MPI_DOUBLE;
}
template <>
inline MPI_Datatype mpi_type<float>() {
  return MPI_FLOAT;
}

}  // namespace bedload
