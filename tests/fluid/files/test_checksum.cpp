#include <gmock/gmock.h>

#include <fstream>

#include "fluid/files/checksum.hpp"
#include "tests/fluid/output_helpers.hpp"

namespace bedload::test {
namespace {

TEST(Checksum, SeesExchangedAndAddedWords) {
  const auto sum = [](std::uint64_t a, std::uint64_t b) {
    return checksum_term(a, 0) + checksum_term(b, 1);
  };
  EXPECT_NE(sum(1, 2), sum(2, 1));
  EXPECT_NE(sum(0, 0), checksum_term(0, 0));
  const Folder folder;
  if (world_rank() == 0) std::ofstream(folder / "f") << std::string(1000, 'a') << "0123456789abc";
  MPI_Barrier(MPI_COMM_WORLD);
  const std::uint64_t together = file_checksum(folder / "f", 5, MPI_COMM_WORLD);
  EXPECT_EQ(together, file_checksum(folder / "f", 5, MPI_COMM_SELF));
  EXPECT_NE(together, file_checksum(folder / "f", 4, MPI_COMM_SELF));
}

}  // namespace
}  // namespace bedload::test
