// Convection and explicit diffusion, each below its own limit and both together.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "fluid/channel/joint_stability.hpp"
#include "fluid/channel/step_limits.hpp"
#include "fluid/grid/diffusion_limit.hpp"
#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double on_cubes = 1.0 / 3;

/// Shares found by a scan of waves in three directions, the velocity along one of them.
TEST(JointStability, SharesOfDiffusionBesideConvection) {
  const std::array<std::array<double, 2>, 7> known{{{0.7, 1.0},
                                                    {1.0, 0.97},
                                                    {1.2, 0.92},
                                                    {1.3, 0.89},
                                                    {1.5, 0.83},
                                                    {1.6, 0.80},
                                                    {1.732, 0.765}}};
  for (const auto& [cfl, share] : known)
    EXPECT_NEAR(stable_share_of_diffusion(cfl, on_cubes), share, 0.005) << cfl;
  EXPECT_EQ(stable_share_of_diffusion(1.74, on_cubes), 0);
  // Thin cells along y: nearly all of the diffusion acts across the waves of convection.
  EXPECT_NEAR(stable_share_of_diffusion(1.5, 0.05), 0.733, 0.005);
}

/// The amplitude of one wave that a hundred steps of the scheme leave: on either side of the limit.
TEST(JointStability, IsWhereWavesBeginToGrow) {
  for (const double cfl : {1.2, 1.5, 1.7}) {
    const double share = stable_share_of_diffusion(cfl, on_cubes);
    const auto largest = [&](double part) {
      double found = 0;
      for (double angle = 0; angle <= 3.14; angle += 0.01)
        for (double across = 0; across <= 1; across += 0.02) {
          const double decay =
              real_limit * part * (2 * across + std::pow(std::sin(angle / 2), 2)) / 3;
          const std::complex<double> z{-decay, cfl * std::sin(angle)};
          std::complex<double> wave{1, 0};
          for (int step = 0; step < 100; ++step) {  // Runge and Kutta's three stages, low storage
            const auto first = wave + z / 3.0 * wave, second = wave + z / 2.0 * first;
            wave += z * second;
          }
          found = std::max(found, std::abs(wave));
        }
      return found;
    };
    EXPECT_LT(largest(0.995 * share), 1.0 + 1e-9) << cfl;
    EXPECT_GT(largest(1.02 * share), 2.0) << cfl;
  }
}

TEST(StepLimits, ChooseAndAllowNoStepThatBothTogetherForbid) {
  Settings s = box({8, 8, 8}, 1.0, 1.0 / 8.1, 1.69);
  s.fluid.diffusion = Diffusion::explicit_;
  const Grid grid = make_grid(s);
  const double longest = explicit_diffusion_limit(grid, s.fluid.kinematic_viscosity);
  s.time.cfl = 1.7;
  const double dt = StepLimits(s, grid).step(1.0);
  EXPECT_LE(dt, longest * stable_share_of_diffusion(dt, on_cubes));
  EXPECT_GT(dt, 0.75 * longest);                          // a rung of the ladder is 4 %
  EXPECT_DOUBLE_EQ(StepLimits(s, grid).step(0.1), 1.69);  // slow flow: diffusion alone

  s.time.cfl = 0;
  const StepLimits fixed(s, grid);
  EXPECT_TRUE(fixed.allows(0.8, 1.69));
  EXPECT_FALSE(fixed.allows(1.5, 1.69));
  EXPECT_THAT(fixed.complaint(3, 5.07, 1.69, 1.5, {1, 2, 3}),
              AllOf(HasSubstr("step 3"), HasSubstr("not together"), HasSubstr("at most 1.48")));
  s.fluid.convection = false;
  EXPECT_TRUE(StepLimits(s, grid).allows(1.5, 1.69));
}

/// Where thin cells take most of the rate of diffusion, less of its limit is left beside
/// convection: 0.80 of it is stable at a CFL number of 1.5 on cubes, and not there.
TEST(StepLimits, KnowThinCells) {
  Settings s = box({8, 8, 8}, 1.0, 1.0 / 8.1, 0.1);
  s.fluid.diffusion = Diffusion::explicit_;
  const auto allowed = [&] {
    const Grid grid = make_grid(s);
    const double part = 0.8 * explicit_diffusion_limit(grid, s.fluid.kinematic_viscosity);
    s.time.step = part;
    return StepLimits(s, grid).allows(1.5, part);
  };
  EXPECT_TRUE(allowed());
  set_y_ends(s, Wall::no_slip, Wall::no_slip);
  s.grid.cells[1] = 32;
  s.grid.y_stretching = 2.0;
  s.time.step = 1e-4;
  EXPECT_FALSE(allowed());
}

}  // namespace
}  // namespace bedload
