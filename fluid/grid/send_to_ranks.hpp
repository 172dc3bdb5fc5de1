#pragma once

#include <mpi.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/grid/mpi_records.hpp"

namespace bedload {

/// Sends the records of to[rank] to each rank, and returns what came, by ascending rank of the
/// sender. A rank sends messages only to ranks for which it has records; how many come is known
/// from one sum over the ranks, which also keeps two such exchanges apart. Collective.
template <class Record>
std::vector<Record> send_to_ranks(MPI_Comm comm, const std::vector<std::vector<Record>>& to) {
  constexpr int tag = 31;
  const int rank = rank_in(comm);
  const auto me = static_cast<std::size_t>(rank);
  const RecordType<Record> record;
  std::vector<int> is_receiver(to.size());
  for (std::size_t r = 0; r < to.size(); ++r) is_receiver[r] = r != me && !to[r].empty() ? 1 : 0;
  int senders = 0;
  MPI_Reduce_scatter_block(is_receiver.data(), &senders, 1, MPI_INT, MPI_SUM, comm);

  std::vector<MPI_Request> requests;
  for (std::size_t r = 0; r < to.size(); ++r)
    if (is_receiver[r] != 0)
      MPI_Isend(to[r].data(), mpi_count(to[r].size(), "records to send"), record.type,
                static_cast<int>(r), tag, comm, &requests.emplace_back());
  std::vector<std::pair<int, std::vector<Record>>> parts;
  if (!to[me].empty()) parts.emplace_back(rank, to[me]);
  for (int n = 0; n < senders; ++n) {
    MPI_Message message;
    MPI_Status status;
    MPI_Mprobe(MPI_ANY_SOURCE, tag, comm, &message, &status);
    int count = 0;
    MPI_Get_count(&status, record.type, &count);
    auto& [sender, records] = parts.emplace_back();
    sender = status.MPI_SOURCE;
    records.resize(static_cast<std::size_t>(count));
    MPI_Mrecv(records.data(), count, record.type, &message, MPI_STATUS_IGNORE);
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  std::sort(parts.begin(), parts.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Record> come;
  for (const auto& part : parts) come.insert(come.end(), part.second.begin(), part.second.end());
  return come;
}

}  // namespace bedload
