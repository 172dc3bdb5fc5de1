#include <gmock/gmock.h>

#include <cmath>

#include "coupling/bedload_dem/motion_rules.hpp"

namespace bedload {
namespace {

using ::testing::HasSubstr;

constexpr double radius = 0.5;
const Vec3 still{0, 0, 0}, middle{5, 2, 3};

/// Ends along y alone.
MotionRules rules() { return {{{0, 0, 0}, {10, 4, 6}, {1, 0, 1}}, 0.01, 0.25}; }

MotionFlaw flaw(const Vec3& position, const Vec3& velocity = still, const Vec3& spin = still) {
  return flaw_of_motion(rules(), position, velocity, spin, radius);
}

// The fastest point of the surface moves by |v| + |omega| R.
TEST(MotionRules, ASphereMayMoveByItsRadiusInAStep) {
  const double limit = radius / rules().time_step;
  EXPECT_EQ(flaw(middle, {0.999 * limit, 0, 0}), MotionFlaw::none);
  EXPECT_EQ(flaw(middle, {0, -1.001 * limit, 0}), MotionFlaw::too_fast);
  EXPECT_EQ(flaw(middle, still, {0, 0, 0.999 * limit / radius}), MotionFlaw::none);
  EXPECT_EQ(flaw(middle, still, {0, 0, 1.001 * limit / radius}), MotionFlaw::too_fast);
  EXPECT_EQ(flaw(middle, {0.6 * limit, 0, 0}, {0, 0.5 * limit / radius, 0}), MotionFlaw::too_fast);
  EXPECT_EQ(flaw(middle, {NAN, 0, 0}), MotionFlaw::too_fast);
}

TEST(MotionRules, TheBoxEndsWhereItIsNotPeriodic) {
  EXPECT_EQ(flaw({5, -0.01, 3}), MotionFlaw::outside);
  EXPECT_EQ(flaw({5, 4.01, 3}), MotionFlaw::outside);
  EXPECT_EQ(flaw({-0.01, 2, 6.01}), MotionFlaw::none);
  EXPECT_EQ(flaw({5, NAN, 3}), MotionFlaw::outside);
}

TEST(MotionRules, AWallMayBeEnteredByAPartOfTheRadius) {
  const double deepest = rules().deepest * radius;
  for (const double depth : {-0.1, 0.0, 0.99 * deepest})
    for (const double y : {radius - depth, 4 - radius + depth}) {
      EXPECT_NEAR(depth_in_walls(rules().box, {5, y, 3}, radius), depth, 1e-12);
      EXPECT_EQ(flaw({5, y, 3}), MotionFlaw::none) << depth;
    }
  EXPECT_EQ(flaw({5, radius - 1.01 * deepest, 3}), MotionFlaw::in_wall);
  EXPECT_EQ(flaw({5, 4 - radius + 1.01 * deepest, 3}), MotionFlaw::in_wall);
}

TEST(MotionRules, AFlawIsToldWithWhatToDo) {
  const auto words = [](MotionFlaw kind) {
    return describe_flaw(kind, rules(), {5, 0.3, 3}, radius);
  };
  EXPECT_EQ(words(MotionFlaw::none), "");
  EXPECT_THAT(words(MotionFlaw::too_fast), HasSubstr("reduce 'time.step' of fluid.toml"));
  EXPECT_THAT(words(MotionFlaw::outside), HasSubstr("put a 'fix wall/gran' where the box ends"));
  EXPECT_THAT(words(MotionFlaw::in_wall),
              HasSubstr("reaches 0.2 out of the box, and at most 0.25"));
}

}  // namespace
}  // namespace bedload
