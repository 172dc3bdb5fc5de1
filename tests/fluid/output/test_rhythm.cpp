#include <gtest/gtest.h>

#include "fluid/output/rhythm.hpp"

namespace bedload {
namespace {

TEST(NextDue, IsTheFirstTimeOfTheRowBehindNow) {
  EXPECT_EQ(next_due(2.0, 0.5, 1.75), 2.0) << "still to come";
  EXPECT_EQ(next_due(2.0, 0.5, 2.0), 2.5) << "now is not behind now";
  EXPECT_EQ(next_due(2.0, 0.5, 2.25), 2.5);
  EXPECT_EQ(next_due(2.0, 0.5, 3.75), 4.0) << "those that a long step has passed are left out";
  EXPECT_EQ(next_due(2.0, 0.5, 4.0), 4.5);
}

// A time that is not behind now would be due for ever.
TEST(NextDue, IsBehindNowWhateverRoundOffDoes) {
  for (const double every : {0.1, 1e-3, 1e-17})
    for (double now = 0.3; now < 1e6; now *= 1.7) {
      const double next = next_due(0.0, every, now);
      EXPECT_GT(next, now) << every;
      EXPECT_LT(next, now + 1.001 * every + 1e-15 * now) << every;
    }
}

}  // namespace
}  // namespace bedload
