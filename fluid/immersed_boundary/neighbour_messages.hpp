#pragma once

#include <mpi.h>

#include <map>
#include <vector>

#include "fluid/grid/mpi_records.hpp"

namespace bedload {

/// Sends and receives one message of numbers per rank; the lengths are known on both sides.
/// @param leaving what goes to each rank
/// @param coming what comes from each rank, of the length that is to come
inline void exchange_numbers(MPI_Comm comm, int tag,
                             const std::map<int, std::vector<double>>& leaving,
                             std::map<int, std::vector<double>>& coming) {
  std::vector<MPI_Request> requests;
  const auto length = [](const auto& message) {
    return mpi_count(message.size(), "numbers to send");
  };
  for (auto& [rank, message] : coming)
    MPI_Irecv(message.data(), length(message), MPI_DOUBLE, rank, tag, comm,
              &requests.emplace_back());
  for (const auto& [rank, message] : leaving)
    MPI_Isend(message.data(), length(message), MPI_DOUBLE, rank, tag, comm,
              &requests.emplace_back());
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

}  // namespace bedload
