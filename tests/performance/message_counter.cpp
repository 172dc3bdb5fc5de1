#include "tests/performance/message_counter.hpp"

#include <mpi.h>

namespace {

std::int64_t sent = 0;

void count(int to, std::int64_t numbers, MPI_Datatype type, MPI_Comm comm) {
  int rank = 0, bytes = 0;
  MPI_Comm_rank(comm, &rank);
  MPI_Type_size(type, &bytes);
  if (to != rank && to != MPI_PROC_NULL) sent += numbers * bytes;
}

}  // namespace

std::int64_t bedload::bytes_sent() { return sent; }

// The calls by which the fluid sends fields and modes; single numbers (MPI_Allreduce) do not count.
extern "C" {

int MPI_Sendrecv(const void* out, int numbers, MPI_Datatype type, int to, int tag, void* in,
                 int most, MPI_Datatype type_in, int from, int tag_in, MPI_Comm comm,
                 MPI_Status* status) {
  count(to, numbers, type, comm);
  return PMPI_Sendrecv(out, numbers, type, to, tag, in, most, type_in, from, tag_in, comm, status);
}

int MPI_Isend(const void* out, int numbers, MPI_Datatype type, int to, int tag, MPI_Comm comm,
              MPI_Request* request) {
  count(to, numbers, type, comm);
  return PMPI_Isend(out, numbers, type, to, tag, comm, request);
}

int MPI_Alltoallv(const void* out, const int numbers[], const int places[], MPI_Datatype type,
                  void* in, const int numbers_in[], const int places_in[], MPI_Datatype type_in,
                  MPI_Comm comm) {
  int ranks = 0;
  MPI_Comm_size(comm, &ranks);
  for (int to = 0; to < ranks; ++to) count(to, numbers[to], type, comm);
  return PMPI_Alltoallv(out, numbers, places, type, in, numbers_in, places_in, type_in, comm);
}

}  // extern "C"
