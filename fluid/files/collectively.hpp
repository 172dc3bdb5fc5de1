#pragma once

#include <mpi.h>

#include <string>

#include "fluid/settings/errors.hpp"

namespace bedload {

/// Runs `work` on every rank of `comm`; when it throws UserError on any of them, all ranks throw
/// the sentence of the lowest one that failed. So no rank waits for one that has given up.
/// Collective. `work` itself must not communicate after the point where it may throw.
template <class Work>
void collectively(MPI_Comm comm, Work&& work) {
  std::string sentence;
  try {
    work();
  } catch (const UserError& error) {
    sentence = error.what();
  }
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  const int mine = sentence.empty() ? ranks : rank;
  int first = mine;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm);
  if (first == ranks) return;
  int length = static_cast<int>(sentence.size());
  MPI_Bcast(&length, 1, MPI_INT, first, comm);
  sentence.resize(static_cast<std::size_t>(length));
  MPI_Bcast(sentence.data(), length, MPI_CHAR, first, comm);
  throw UserError(sentence);
}

/// The same for work that one rank does for all (rank 0 writes a file, the others wait for word).
template <class Work>
void on_first_rank(MPI_Comm comm, Work&& work) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  collectively(comm, [&] {
    if (rank == 0) work();
  });
}

/// Whether all ranks of `comm` come here within `seconds` of this one: whoever ends by a mistake
/// asks this before it does anything that the others have to take part in. Where they do not, a
/// message stays under way in `comm`, which then is of no more use.
inline bool all_arrive(MPI_Comm comm, double seconds) {
  const double end = MPI_Wtime() + seconds;
  MPI_Request request;
  MPI_Ibarrier(comm, &request);
  int have_arrived = 0;
  while (have_arrived == 0 && MPI_Wtime() < end)
    MPI_Test(&request, &have_arrived, MPI_STATUS_IGNORE);
  return have_arrived != 0;
}

}  // namespace bedload
