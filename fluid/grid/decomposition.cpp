#include "fluid/grid/decomposition.hpp"

#include <algorithm>
#include <cassert>
#include <exception>
#include <numeric>

#include "fluid/grid/mpi_ranks.hpp"

namespace bedload {
namespace {

MPI_Comm split(MPI_Comm comm, int colour) {
  MPI_Comm part = MPI_COMM_NULL;
  MPI_Comm_split(comm, colour, 0, &part);
  return part;
}

// Message tags: with two parts along a periodic direction the neighbours are one rank.
constexpr int upwards = 1, downwards = 2, forwards = 3, backwards = 4;

}  // namespace

std::vector<int> divide_evenly(std::span<const double> cost, int parts) {
  const int planes = static_cast<int>(cost.size());
  assert(parts <= planes);
  const double total = std::accumulate(cost.begin(), cost.end(), 0.0);
  std::vector<int> first{0};
  double below = 0.0;  // cost of the planes given to parts so far
  int plane = 0;
  for (int part = 1; part < parts; ++part) {
    const double target = total * part / parts;
    const int lowest = plane + 1;
    const int highest = planes - (parts - part);  // leaves one plane for each part to come
    while (plane < highest) {
      const double next = below + cost[static_cast<std::size_t>(plane)];
      if (plane >= lowest && next - target > target - below) break;
      below = next;
      ++plane;
    }
    first.push_back(plane);
  }
  first.push_back(planes);
  return first;
}

Cuts even_cuts(const Grid& grid, int ranks, int z_parts) {
  assert(ranks % z_parts == 0);
  const auto even = [&grid](std::size_t direction, int parts) {
    return divide_evenly(std::vector<double>(static_cast<std::size_t>(grid.cells[direction]), 1.0),
                         parts);
  };
  return {.y = even(1, ranks / z_parts), .z = even(2, z_parts)};
}

OwnComm::~OwnComm() {
  // Freeing waits for the others, which a rank that gives up must not do.
  if (comm_ != MPI_COMM_NULL && std::uncaught_exceptions() == 0) MPI_Comm_free(&comm_);
}

Decomposition::Decomposition(const Grid& grid, MPI_Comm comm, const Cuts& cuts)
    : comm_(comm),
      rank_(rank_in(comm)),
      cuts_(cuts),
      y_comm_(split(comm, z_part())),
      z_comm_(split(comm, y_part())) {
  assert(ranks() == size_of(comm));
  const auto neighbour = [&](int direction, int y, int z) {
    if (grid.periodic(direction)) {
      y = (y + y_parts()) % y_parts();
      z = (z + z_parts()) % z_parts();
    }
    const bool inside = y >= 0 && y < y_parts() && z >= 0 && z < z_parts();
    return inside ? y * z_parts() + z : MPI_PROC_NULL;
  };
  below_ = neighbour(1, y_part() - 1, z_part());
  above_ = neighbour(1, y_part() + 1, z_part());
  back_ = neighbour(2, y_part(), z_part() - 1);
  front_ = neighbour(2, y_part(), z_part() + 1);
}

Decomposition::Decomposition(const Grid& grid, MPI_Comm comm)
    : Decomposition(grid, comm, even_cuts(grid, size_of(comm))) {}

template <class Real>
void Decomposition::exchange_rows(Field<Real>& field) const {
  if (!divides_rows()) return;
  const int last = field.nz() - 1;
  MPI_Datatype row = MPI_DATATYPE_NULL;  // one z row of every own plane
  MPI_Type_vector(field.planes(), static_cast<int>(field.row_size()),
                  static_cast<int>(field.plane_size()), mpi_type<Real>(), &row);
  MPI_Type_commit(&row);
  MPI_Sendrecv(field.row_block(0, last), 1, row, front_, forwards, field.row_block(0, -1), 1, row,
               back_, forwards, comm_, MPI_STATUS_IGNORE);
  MPI_Sendrecv(field.row_block(0, 0), 1, row, back_, backwards, field.row_block(0, last + 1), 1,
               row, front_, backwards, comm_, MPI_STATUS_IGNORE);
  MPI_Type_free(&row);
}

template <class Real>
void Decomposition::exchange_planes(Field<Real>& field) const {
  const MPI_Datatype type = mpi_type<Real>();
  const int length = static_cast<int>(field.plane_size()), top = field.planes() - 1;
  MPI_Sendrecv(field.plane(top), length, type, above_, upwards, field.plane(-1), length, type,
               below_, upwards, comm_, MPI_STATUS_IGNORE);
  MPI_Sendrecv(field.plane(0), length, type, below_, downwards, field.plane(top + 1), length, type,
               above_, downwards, comm_, MPI_STATUS_IGNORE);
}

template void Decomposition::exchange_rows(Field<float>&) const;
template void Decomposition::exchange_rows(Field<double>&) const;
template void Decomposition::exchange_planes(Field<float>&) const;
template void Decomposition::exchange_planes(Field<double>&) const;

}  // namespace bedload
