#pragma once

#include <mpi.h>

#include <array>
#include <span>
#include <vector>

#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"

namespace bedload {

/// Where the box is cut along one direction: the first plane (or row) of each part and, behind the
/// last one, their number. `parts` parts of at least one whose costs are as even as whole planes
/// allow; `cost` holds one number each. There must be no more parts than planes.
std::vector<int> divide_evenly(std::span<const double> cost, int parts);

/// Cuts along y (between planes) and along z (between rows), for one rank per block.
struct Cuts {
  std::vector<int> y, z;

  int y_parts() const { return static_cast<int>(y.size()) - 1; }
  int z_parts() const { return static_cast<int>(z.size()) - 1; }
};

/// Blocks of equal size; `z_parts` (a divisor of `ranks`) of them side by side along z.
Cuts even_cuts(const Grid& grid, int ranks, int z_parts = 1);

/// A communicator of our own.
class OwnComm {
 public:
  OwnComm() = default;
  explicit OwnComm(MPI_Comm comm) : comm_(comm) {}
  OwnComm(const OwnComm&) = delete;
  OwnComm& operator=(const OwnComm&) = delete;
  ~OwnComm();
  operator MPI_Comm() const { return comm_; }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
};

/// How the cells are divided over the ranks of a communicator: each holds a block of whole x rows,
/// planes first() .. along y and rows first_row() .. along z. Blocks that lie side by side along z
/// have neighbouring ranks: they exchange most. Local plane j and row k of a field are global plane
/// first() + j and row first_row() + k.
class Decomposition {
 public:
  Decomposition(const Grid& grid, MPI_Comm comm, const Cuts& cuts);
  /// Slabs of equal height.
  Decomposition(const Grid& grid, MPI_Comm comm);
  const Cuts& cuts() const { return cuts_; }

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  int ranks() const { return y_parts() * z_parts(); }

  int y_parts() const { return cuts_.y_parts(); }
  int z_parts() const { return cuts_.z_parts(); }
  /// Which of them this rank holds.
  int y_part() const { return rank_ / z_parts(); }
  int z_part() const { return rank_ % z_parts(); }
  /// The ranks that hold the same rows, from the lowest planes to the highest.
  MPI_Comm y_comm() const { return y_comm_; }
  /// The ranks that hold the same planes, from the first rows to the last.
  MPI_Comm z_comm() const { return z_comm_; }

  int first() const { return first(y_part()); }
  int planes() const { return planes(y_part()); }
  int first(int y_part) const { return cuts_.y[static_cast<std::size_t>(y_part)]; }
  int planes(int y_part) const { return first(y_part + 1) - first(y_part); }
  int first_row() const { return first_row(z_part()); }
  int rows() const { return rows(z_part()); }
  int first_row(int z_part) const { return cuts_.z[static_cast<std::size_t>(z_part)]; }
  int rows(int z_part) const { return first_row(z_part + 1) - first_row(z_part); }
  Extent extent() const { return {planes(), rows()}; }

  /// Whether a global plane, a global row, or both are this rank's own.
  bool holds_plane(int plane) const { return plane >= first() && plane < first() + planes(); }
  bool holds_row(int row) const { return row >= first_row() && row < first_row() + rows(); }
  bool holds(int plane, int row) const { return holds_plane(plane) && holds_row(row); }

  /// Neighbouring ranks, MPI_PROC_NULL beyond a wall; the rank itself where a periodic direction
  /// closes on it.
  int below() const { return below_; }
  int above() const { return above_; }
  int back() const { return back_; }    ///< towards lower z
  int front() const { return front_; }  ///< towards higher z
  bool at_lower_wall() const { return below_ == MPI_PROC_NULL; }
  bool at_upper_wall() const { return above_ == MPI_PROC_NULL; }
  bool at_back_wall() const { return back_ == MPI_PROC_NULL; }
  bool at_front_wall() const { return front_ == MPI_PROC_NULL; }
  /// Whether fields have ghost rows that a neighbour fills (undivided periodic z wraps in storage).
  bool divides_rows() const { return z_parts() > 1; }

  /// Fills the ghost rows -1 and rows() of the own planes, x ghosts included, with the neighbours'
  /// cells. Those beyond a wall are left alone. Collective.
  template <class Real>
  void exchange_rows(Field<Real>& field) const;
  /// The ghost planes -1 and planes() likewise, with all rows that they have, ghost rows included.
  template <class Real>
  void exchange_planes(Field<Real>& field) const;
  /// Both, in this order: the edges common to ghost rows and planes come along.
  template <class Real>
  void exchange(Field<Real>& field) const {
    exchange_rows(field);
    exchange_planes(field);
  }

 private:
  MPI_Comm comm_;
  int rank_ = 0;
  Cuts cuts_;
  OwnComm y_comm_, z_comm_;
  int below_, above_, back_, front_;
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
