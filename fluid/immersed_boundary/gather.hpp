#pragma once

#include <mpi.h>

#include <algorithm>
#include <span>
#include <vector>

#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/grid/mpi_records.hpp"

namespace bedload {

/// The records of all ranks on every rank, ascending tags. For output and tests: the time step
/// itself never needs all spheres in one place. Collective.
template <class Record>
std::vector<Record> gather_by_tag(MPI_Comm comm, std::span<const Record> mine) {
  const int ranks = size_of(comm);
  const RecordType<Record> record;
  const int count = mpi_count(mine.size(), "records");
  std::vector<int> counts(static_cast<std::size_t>(ranks)), places;
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::vector<Record> all(places_of(counts, places));
  MPI_Allgatherv(mine.data(), count, record.type, all.data(), counts.data(), places.data(),
                 record.type, comm);
  std::sort(all.begin(), all.end(), [](const Record& a, const Record& b) { return a.tag < b.tag; });
  return all;
}

}  // namespace bedload
