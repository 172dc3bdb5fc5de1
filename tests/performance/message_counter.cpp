#include "tests/performance/message_counter.hpp"

#include <mpi.h>

namespace {

bedload::Traffic so_far;

void count(int to, std::int64_t numbers, MPI_Datatype type, MPI_Comm comm) {
  int between = 0, rank = 0, bytes = 0;
  PMPI_Comm_test_inter(comm, &between);  // in the other program nobody is this rank
  PMPI_Comm_rank(comm, &rank);
  PMPI_Type_size(type, &bytes);
  if (to == MPI_PROC_NULL || (between == 0 && to == rank)) return;
  so_far.bytes += numbers * bytes;
  ++so_far.messages;
  if (bedload::after_message) bedload::after_message();
}

void count_gathered(const int numbers[], MPI_Datatype type, MPI_Comm comm) {
  int ranks = 0, bytes = 0;
  PMPI_Comm_size(comm, &ranks);
  PMPI_Type_size(type, &bytes);
  for (int from = 0; from < ranks; ++from)
    so_far.gathered += static_cast<std::int64_t>(numbers[from]) * bytes;
}

}  // namespace

const bedload::Traffic& bedload::traffic() { return so_far; }

// The calls by which bedload and LIGGGHTS send.
extern "C" {

int MPI_Send(const void* out, int numbers, MPI_Datatype type, int to, int tag, MPI_Comm comm) {
  count(to, numbers, type, comm);
  return PMPI_Send(out, numbers, type, to, tag, comm);
}

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
  PMPI_Comm_size(comm, &ranks);
  for (int to = 0; to < ranks; ++to)
    if (numbers[to] > 0) count(to, numbers[to], type, comm);
  return PMPI_Alltoallv(out, numbers, places, type, in, numbers_in, places_in, type_in, comm);
}

int MPI_Allreduce(const void* mine, void* all, int numbers, MPI_Datatype type, MPI_Op operation,
                  MPI_Comm comm) {
  ++so_far.sums;
  return PMPI_Allreduce(mine, all, numbers, type, operation, comm);
}

int MPI_Allgatherv(const void* mine, int numbers, MPI_Datatype type, void* all,
                   const int numbers_in[], const int places[], MPI_Datatype type_in,
                   MPI_Comm comm) {
  count_gathered(numbers_in, type_in, comm);
  return PMPI_Allgatherv(mine, numbers, type, all, numbers_in, places, type_in, comm);
}

int MPI_Gatherv(const void* mine, int numbers, MPI_Datatype type, void* all, const int numbers_in[],
                const int places[], MPI_Datatype type_in, int root, MPI_Comm comm) {
  int rank = 0;
  PMPI_Comm_rank(comm, &rank);
  if (rank == root)
    count_gathered(numbers_in, type_in, comm);
  else
    count(root, numbers, type, comm);
  return PMPI_Gatherv(mine, numbers, type, all, numbers_in, places, type_in, root, comm);
}

}  // extern "C"
