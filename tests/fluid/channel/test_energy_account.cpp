// What forcing, viscosity, convection and driving give to the flow's kinetic energy adds up to its
// change.

#include <gtest/gtest.h>

#include <cmath>
#include <type_traits>
#include <vector>

#include "fluid/channel/energy_account.hpp"
#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

Settings stream(const Ends& ends, double stretching) {
  Settings s = box({24, 16, 12}, 1.0 / 16, 0.01, 0.004);
  set_ends(s, ends);
  disturb(s, 1.0, 0.5);
  s.grid.y_stretching = stretching;
  if (ends[0] == periodic) {
    s.flow.driving = Driving::bulk_velocity;
    s.flow.bulk_velocity = 1.0;
  }
  return s;
}

/// A flow, perhaps with a fixed sphere in it, and its account.
template <class Real>
class Followed {
 public:
  Followed(const Settings& s, bool sphere)
      : channel_(s, MPI_COMM_WORLD),
        account_(channel_.grid(), channel_.decomposition()),
        implicit_(s.fluid.diffusion == Diffusion::implicit) {
    const SphereState held{.tag = 1, .position = {0.7, 0.45, 0.4}, .radius = 0.25, .mobile = false};
    if (sphere) channel_.set_spheres(std::vector<SphereState>{held});
  }

  /// One step; returns what the energy changes by, per mass and time.
  double step() {
    const double dt = channel_.time_step(), before = energy();
    for (int stage = 0; stage < stage_count; ++stage) {
      account_.begin_stage(channel_.velocity(), stage);
      channel_.predict(stage);
      if (channel_.immersed_boundary()) {
        account_.predicted(channel_.velocity());
        channel_.force_spheres(stage);
        account_.forced(channel_.velocity());
      }
      channel_.project(stage);
      account_.end_stage(channel_.velocity(), stage, dt, channel_.settings().fluid, implicit_);
    }
    channel_.finish_step();
    return (energy() - before) / dt;
  }
  const EnergyWork& work() const { return account_.work(); }
  double driving() const { return channel_.driving_force() * channel_.bulk_velocity(); }

 private:
  double energy() const { return channel_.kinetic_energy() / channel_.grid().volume(); }

  Channel<Real> channel_;
  EnergyAccount<Real> account_;
  bool implicit_;
};

template <class Real>
class EnergyAccounts : public testing::Test {};
using Precisions = testing::Types<double, float>;
TYPED_TEST_SUITE(EnergyAccounts, Precisions);

/// To round-off, with every kind of end, cubes and stretched, with a sphere and without; and each
/// term is large enough that it would show if it were zero, doubled or turned.
TYPED_TEST(EnergyAccounts, CloseOnAnyRanks) {
  struct Case {
    Ends ends;
    double stretching;
    bool sphere, convection = true;
  };
  for (const Case& c : {Case{{periodic, open_channel, periodic}, 0.0, true},
                        Case{{periodic, periodic, periodic}, 0.0, true},
                        Case{{periodic, periodic, periodic}, 0.0, true, false},
                        Case{{no_slip, no_slip, no_slip}, 0.0, true},
                        Case{{free_slip, under_a_lid, open_channel}, 0.0, false},
                        Case{{periodic, no_slip, periodic}, 1.3, false},
                        Case{{periodic, open_channel, no_slip}, 1.3, false}}) {
    SCOPED_TRACE(name_of(c.ends) + (c.sphere ? " with a sphere" : ""));
    Settings s = stream(c.ends, c.stretching);
    s.fluid.convection = c.convection;
    Followed<TypeParam> flow(s, c.sphere);
    for (int n = 0; n < 3; ++n) {
      const double change = flow.step();
      const EnergyWork& work = flow.work();
      const double driving = c.ends[0] == periodic ? flow.driving() : 0.0;
      // Velocities of order 1 in a step of 0.004: a few roundings of their squares, all one way.
      const double bound = 4 * epsilon<TypeParam>() / 0.004;
      EXPECT_NEAR(change, work.forcing + work.viscous + work.convective + driving, bound);
      EXPECT_LT(work.viscous, -100 * bound);
      if (!c.convection)
        EXPECT_EQ(work.convective, 0.0);
      else if (std::is_same_v<TypeParam, double>)
        EXPECT_GT(std::abs(work.convective), 100 * bound);
      if (c.sphere) EXPECT_GT(std::abs(work.forcing), 100 * bound);
      if (!c.sphere) EXPECT_EQ(work.forcing, 0.0);
    }
  }
}

/// What is not followed is no number, rather than a part of it: viscosity, and of the markers'
/// force what stands in the equation of implicit diffusion.
TEST(EnergyAccount, SaysWhatImplicitDiffusionHides) {
  for (const bool sphere : {false, true}) {
    Settings s = stream({periodic, open_channel, periodic}, 0.0);
    s.fluid.diffusion = Diffusion::implicit;
    Followed<double> flow(s, sphere);
    flow.step();
    EXPECT_TRUE(std::isnan(flow.work().viscous));
    EXPECT_EQ(std::isnan(flow.work().forcing), sphere);
    EXPECT_FALSE(std::isnan(flow.work().convective));
  }
}

/// Power of convection over the step length: of third order in a smooth flow, where nothing else
/// acts; of first beside a sphere, what is left of whose slip differs from stage to stage.
TEST(EnergyAccount, ConvectionWorksByTheTimeSchemesErrorAlone) {
  const auto convective = [](double dt, int steps, bool sphere) {
    Settings s = stream({periodic, free_slip, periodic}, 0.0);
    s.fluid.kinematic_viscosity = sphere ? 0.01 : 1e-30;
    s.time.step = dt;
    Followed<double> flow(s, sphere);
    double sum = 0.0;
    for (int n = 0; n < steps; ++n) {
      flow.step();
      if (n >= steps / 2) sum += flow.work().convective;
    }
    const int later = steps - steps / 2;
    return std::abs(sum / later);
  };
  const double smooth = convective(0.008, 16, false) / convective(0.004, 32, false);
  EXPECT_GT(smooth, 6.0);
  EXPECT_LT(smooth, 20.0);
  const double beside = convective(0.008, 16, true) / convective(0.004, 32, true);
  EXPECT_GT(beside, 1.3);
  EXPECT_LT(beside, 4.0);
}

}  // namespace
}  // namespace bedload
