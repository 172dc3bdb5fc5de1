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

/// The records of all ranks on the first one, ascending tags; none on the others, which hold their
/// own only, so that what they hold does not grow with the number of ranks. Collective.
template <class Record>
std::vector<Record> gather_on_first(MPI_Comm comm, std::span<const Record> mine) {
  int ranks = 1, rank = 0;
  MPI_Comm_size(comm, &ranks);
  MPI_Comm_rank(comm, &rank);
  MPI_Datatype record;  // counts are those of records, so that 32 bits reach for 2^31 of them
  MPI_Type_contiguous(sizeof(Record), MPI_BYTE, &record);
  MPI_Type_commit(&record);
  const int count = static_cast<int>(mine.size());
  std::vector<int> counts(rank == 0 ? static_cast<std::size_t>(ranks) : 0),
      places(counts.size(), 0);
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  for (std::size_t r = 1; r < counts.size(); ++r) places[r] = places[r - 1] + counts[r - 1];
  const int total = counts.empty() ? 0 : places.back() + counts.back();
  std::vector<Record> all(static_cast<std::size_t>(total));
  MPI_Gatherv(mine.data(), count, record, all.data(), counts.data(), places.data(), record, 0,
              comm);
  MPI_Type_free(&record);
  std::sort(all.begin(), all.end(), [](const Record& a, const Record& b) { return a.tag < b.tag; });
  return all;
}

}  // namespace bedload
