#include "fluid/decomposition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "fluid/errors.hpp"

namespace bedload {

std::vector<int> divide_planes(std::span<const double> cost, int parts) {
  const int planes = static_cast<int>(cost.size());
  if (parts > planes)
    throw UserError(
        fmt::format("The fluid runs on {} ranks, but 'grid.cells' has only {} planes along y; use "
                    "at most {} fluid ranks.",
                    parts, planes, planes));
  const double total = std::accumulate(cost.begin(), cost.end(), 0.0);
  std::vector<int> first{0};
  double below = 0.0;  // cost of the planes dealt out so far
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

Decomposition::Decomposition(const Grid& grid, MPI_Comm comm, std::span<const double> plane_cost)
    : comm_(comm) {
  int ranks = 0;
  MPI_Comm_rank(comm, &rank_);
  MPI_Comm_size(comm, &ranks);
  const std::vector<double> even(static_cast<std::size_t>(grid.cells[1]), 1.0);
  first_ = divide_planes(plane_cost.empty() ? std::span<const double>(even) : plane_cost, ranks);
  const bool closed = grid.periodic(1);
  if (rank_ > 0 || closed) below_ = (rank_ + ranks - 1) % ranks;
  if (rank_ < ranks - 1 || closed) above_ = (rank_ + 1) % ranks;
}

int Decomposition::owner(int global_plane) const {
  const auto behind = std::upper_bound(first_.begin(), first_.end(), global_plane);
  return static_cast<int>(behind - first_.begin()) - 1;
}

namespace {

constexpr int upwards = 1, downwards = 2;  // message tags: two ranks can be neighbours twice

template <class Real>
int message_length(const Field<Real>& field) {
  return static_cast<int>(field.plane_size());
}

}  // namespace

template <class Real>
void Decomposition::exchange(Field<Real>& field) const {
  const int length = message_length(field), top = field.planes() - 1;
  const MPI_Datatype type = mpi_type<Real>();
  MPI_Sendrecv(field.plane(top), length, type, above_, upwards, field.plane(-1), length, type,
               below_, upwards, comm_, MPI_STATUS_IGNORE);
  MPI_Sendrecv(field.plane(0), length, type, below_, downwards, field.plane(top + 1), length, type,
               above_, downwards, comm_, MPI_STATUS_IGNORE);
}

template <class Real>
void Decomposition::add_ghosts(Field<Real>& field) const {
  const int length = message_length(field), top = field.planes() - 1;
  const MPI_Datatype type = mpi_type<Real>();
  for (int j = -1; j <= top + 1; ++j) fold_x_ghosts(field, j);
  std::vector<Real> received(field.plane_size());
  const auto add_to = [&](int j) {
    Real* plane = field.plane(j);
    for (std::size_t n = 0; n < received.size(); ++n) plane[n] += received[n];
  };
  const auto clear = [&](int j) { std::fill_n(field.plane(j), field.plane_size(), Real{}); };

  MPI_Sendrecv(field.plane(-1), length, type, below_, downwards, received.data(), length, type,
               above_, downwards, comm_, MPI_STATUS_IGNORE);
  if (!at_upper_wall()) add_to(top);
  MPI_Sendrecv(field.plane(top + 1), length, type, above_, upwards, received.data(), length, type,
               below_, upwards, comm_, MPI_STATUS_IGNORE);
  if (!at_lower_wall()) add_to(0);
  if (!at_lower_wall()) clear(-1);
  if (!at_upper_wall()) clear(top + 1);
}

template void Decomposition::exchange(Field<float>&) const;
template void Decomposition::exchange(Field<double>&) const;
template void Decomposition::add_ghosts(Field<float>&) const;
template void Decomposition::add_ghosts(Field<double>&) const;

}  // namespace bedload
