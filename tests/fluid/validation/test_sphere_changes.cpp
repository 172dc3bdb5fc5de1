#include <gmock/gmock.h>

#include "fluid/validation/sphere_changes.hpp"

namespace bedload {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

SphereState grain(std::int64_t tag, double x, double radius = 0.5, double density = 2.5) {
  return {
      .tag = tag, .position = {x, 1.0, 1.0}, .radius = radius, .mobile = true, .density = density};
}

Grid periodic_box() {
  Grid grid;
  grid.length = {4.0, 2.0, 3.0};
  return grid;
}

// Each sphere is checked when it comes or becomes another one, and no other is checked again.
TEST(SphereChanges, NamesThoseThatAreNewOrOthers) {
  SphereChanges changes(periodic_box());
  EXPECT_THAT(changes.update(std::vector{grain(2, 1.0), grain(5, 3.0)}), ElementsAre(2, 5));
  EXPECT_THAT(changes.update(std::vector{grain(2, 1.0), grain(5, 3.0)}), IsEmpty());
  EXPECT_THAT(changes.update(std::vector{grain(2, 1.3), grain(5, 2.9)}), IsEmpty()) << "moved";
  EXPECT_THAT(changes.update(std::vector{grain(2, 1.9), grain(5, 2.9)}), ElementsAre(2))
      << "moved by more than a radius";
  EXPECT_THAT(changes.update(std::vector{grain(2, 1.9, 0.4), grain(5, 2.9)}), ElementsAre(2))
      << "another radius";
  EXPECT_THAT(changes.update(std::vector{grain(2, 1.9, 0.4), grain(5, 2.9, 0.5, 2.4)}),
              ElementsAre(5))
      << "another density";
}

TEST(SphereChanges, FollowsTagsThatComeAndGo) {
  SphereChanges changes(periodic_box());
  changes.update(std::vector{grain(2, 1.0), grain(5, 3.0), grain(9, 2.0)});
  EXPECT_THAT(changes.update(std::vector{grain(2, 1.0), grain(9, 2.0)}), IsEmpty())
      << "one is gone";
  EXPECT_THAT(
      changes.update(std::vector{grain(1, 0.5), grain(2, 1.0), grain(5, 3.0), grain(9, 2.0)}),
      ElementsAre(1, 5))
      << "one is new, one is back";
}

TEST(SphereChanges, KnowsThatAPeriodicEndIsNoWayAndLooksAtMobileSpheresAlone) {
  SphereChanges changes(periodic_box());
  SphereState fixed = grain(3, 2.0);
  fixed.mobile = false;
  EXPECT_THAT(changes.update(std::vector{grain(2, 3.95), fixed}), ElementsAre(2));
  fixed.position.x() = 0.5;
  EXPECT_THAT(changes.update(std::vector{grain(2, 0.05), fixed}), IsEmpty());
}

}  // namespace
}  // namespace bedload
