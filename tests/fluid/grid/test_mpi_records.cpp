#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "fluid/grid/mpi_records.hpp"

namespace bedload {
namespace {

constexpr std::uint64_t most = (1ULL << 31) - 1;

TEST(MpiCount, SpeaksWhere32BitsEnd) {
  EXPECT_EQ(mpi_count(most, "grains"), 2147483647);
  try {
    mpi_count(most + 1, "grains");
    FAIL() << "a count that wraps around";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("2147483648 grains"));
  }
}

TEST(MpiCount, PlacesOfPartsSpeakAsWell) {
  std::vector<int> places;
  EXPECT_EQ(places_of(std::array{3, 0, 4}, places), 7U);
  EXPECT_THAT(places, testing::ElementsAre(0, 3, 3));
  // Each part fits, where the third would begin does not.
  EXPECT_THROW(places_of(std::array{2000000000, 2000000000, 1}, places), UserError);
  EXPECT_EQ(places_of(std::array{2000000000, 2000000000}, places), 4000000000U);
}

}  // namespace
}  // namespace bedload
