// Takes the place of a program of another version in an MPI job: says who it is as every version
// does (coupling/job/roles.cpp, Announcement), and then waits, as a partner would.

#include <mpi.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

struct Announcement {
  std::array<char, 16> greeting{};
  std::int32_t program = 0;
  std::int32_t protocol = 1;
  std::uint64_t layout = 1;
  std::array<char, 32> version{};
};
static_assert(sizeof(Announcement) == 64);

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  Announcement mine;
  mine.program = argc > 1 && std::strcmp(argv[1], "dem") == 0 ? 1 : 0;
  std::strcpy(mine.greeting.data(), "bedload");
  std::strcpy(mine.version.data(), "0.0.1");
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  std::vector<Announcement> all(static_cast<std::size_t>(size));
  MPI_Allgather(&mine, sizeof mine, MPI_BYTE, all.data(), sizeof mine, MPI_BYTE, MPI_COMM_WORLD);
  for (;;) pause();
}
