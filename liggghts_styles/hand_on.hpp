#pragma once

#include <mpi.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "comm.h"

namespace bedload {

/// The ranks whose parts of the box touch this rank's, through periodic ends as well; ascending,
/// without itself. LIGGGHTS hands a sphere to one of them when it leaves.
inline std::vector<int> neighbour_ranks(const LAMMPS_NS::Comm& comm) {
  std::vector<int> ranks;
  const auto wrapped = [&comm](int d, int shift) {
    const int parts = comm.procgrid[d];
    return (comm.myloc[d] + shift + parts) % parts;
  };
  for (const int x : {-1, 0, 1})
    for (const int y : {-1, 0, 1})
      for (const int z : {-1, 0, 1})
        ranks.push_back(comm.grid2proc[wrapped(0, x)][wrapped(1, y)][wrapped(2, z)]);
  std::sort(ranks.begin(), ranks.end());
  ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
  std::erase(ranks, comm.me);
  return ranks;
}

/// Records of spheres that this rank does not own any more go to the rank that does: take(record)
/// says whether that is this one. First to the neighbours; what none of them takes, which is rare,
/// to all. Returns on the first rank the records that no rank took, none on the others. Collective.
/// MPI counts records, not bytes: LIGGGHTS' numbers of spheres end before 32 bits do.
template <class Record, class Take>
std::vector<Record> hand_on(MPI_Comm world, const std::vector<int>& neighbours,
                            const std::vector<Record>& strays, Take take) {
  constexpr int strays_tag = 41, taken_tag = 42;
  MPI_Datatype type = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(sizeof(Record), MPI_BYTE, &type);
  MPI_Type_commit(&type);
  const auto count = [](const auto& records) { return static_cast<int>(records.size()); };
  std::vector<MPI_Request> requests(neighbours.size());
  for (std::size_t n = 0; n < neighbours.size(); ++n)
    MPI_Isend(strays.data(), count(strays), type, neighbours[n], strays_tag, world, &requests[n]);
  std::vector<std::vector<char>> answers(neighbours.size());
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    MPI_Status status;
    int number = 0;
    MPI_Probe(neighbours[n], strays_tag, world, &status);
    MPI_Get_count(&status, type, &number);
    std::vector<Record> come(static_cast<std::size_t>(number));
    MPI_Recv(come.data(), number, type, neighbours[n], strays_tag, world, MPI_STATUS_IGNORE);
    for (const Record& record : come) answers[n].push_back(take(record) ? 1 : 0);
    if (!come.empty())
      MPI_Isend(answers[n].data(), count(answers[n]), MPI_CHAR, neighbours[n], taken_tag, world,
                &requests.emplace_back());
  }
  std::vector<char> is_taken(strays.size(), 0), by_one(strays.size());
  if (!strays.empty())
    for (const int neighbour : neighbours) {
      MPI_Recv(by_one.data(), count(by_one), MPI_CHAR, neighbour, taken_tag, world,
               MPI_STATUS_IGNORE);
      for (std::size_t n = 0; n < strays.size(); ++n) is_taken[n] |= by_one[n];
    }
  MPI_Waitall(count(requests), requests.data(), MPI_STATUSES_IGNORE);

  std::vector<Record> left;
  for (std::size_t n = 0; n < strays.size(); ++n)
    if (is_taken[n] == 0) left.push_back(strays[n]);
  int mine = count(left), most = 0, rank = 0, ranks = 1;
  MPI_Allreduce(&mine, &most, 1, MPI_INT, MPI_MAX, world);
  if (most == 0) {
    MPI_Type_free(&type);
    return {};
  }
  MPI_Comm_rank(world, &rank);
  MPI_Comm_size(world, &ranks);
  std::vector<int> sizes(static_cast<std::size_t>(ranks)), places(sizes.size(), 0);
  MPI_Allgather(&mine, 1, MPI_INT, sizes.data(), 1, MPI_INT, world);
  for (std::size_t n = 1; n < sizes.size(); ++n) places[n] = places[n - 1] + sizes[n - 1];
  std::vector<Record> all(static_cast<std::size_t>(places.back() + sizes.back()));
  MPI_Allgatherv(left.data(), mine, type, all.data(), sizes.data(), places.data(), type, world);
  MPI_Type_free(&type);
  std::vector<int> found(all.size(), 0);
  for (std::size_t n = 0; n < all.size(); ++n) found[n] = take(all[n]) ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, found.data(), count(found), MPI_INT, MPI_MAX, world);
  std::vector<Record> lost;
  for (std::size_t n = 0; n < all.size() && rank == 0; ++n)
    if (found[n] == 0) lost.push_back(all[n]);
  return lost;
}

}  // namespace bedload
