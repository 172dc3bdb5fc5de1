#pragma once

#include <mpi.h>

#include <algorithm>
#include <span>
#include <vector>

namespace bedload {

/// The records of all ranks on every rank, ascending tags. For output and tests: the time step
/// itself never needs all spheres in one place. Collective.
template <class Record>
std::vector<Record> gather_by_tag(MPI_Comm comm, std::span<const Record> mine) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const int bytes = static_cast<int>(mine.size_bytes());
  std::vector<int> sizes(static_cast<std::size_t>(ranks)), places(sizes.size(), 0);
  MPI_Allgather(&bytes, 1, MPI_INT, sizes.data(), 1, MPI_INT, comm);
  for (std::size_t r = 1; r < sizes.size(); ++r) places[r] = places[r - 1] + sizes[r - 1];
  const int total = places.back() + sizes.back();
  std::vector<Record> all(static_cast<std::size_t>(total) / sizeof(Record));
  MPI_Allgatherv(mine.data(), bytes, MPI_BYTE, all.data(), sizes.data(), places.data(), MPI_BYTE,
                 comm);
  std::sort(all.begin(), all.end(), [](const Record& a, const Record& b) { return a.tag < b.tag; });
  return all;
}

}  // namespace bedload
