#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "fluid/channel/diagnostics.hpp"
#include "fluid/channel/start_field.hpp"
#include "fluid/grid/diffusion_limit.hpp"
#include "fluid/output/phase_table.hpp"
#include "fluid/settings/errors.hpp"
#include "tests/fluid/carry_over.hpp"
#include "tests/fluid/flow_case.hpp"
#include "tests/fluid/output_helpers.hpp"

namespace bedload {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;

/// The sentence of the UserError that `work` throws; empty when it throws none.
template <class Work>
std::string complaint(Work&& work) {
  try {
    work();
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(UserMistakes, AreNamedInOneSentence) {
  const Settings good = box({8, 8, 8}, 0.125, 1e-2, 0.01);
  EXPECT_EQ(complaint([&] { Channel<double>(good, MPI_COMM_WORLD); }), "");

  Settings s = good;
  s.time.step = 2.0;  // nu dt/h^2 = 1.28; allowed 2.5127/12 = 0.2094
  EXPECT_EQ(complaint([&] { Channel<double>(s, MPI_COMM_WORLD); }), "");  // implicit by itself
  s.fluid.diffusion = Diffusion::explicit_;
  EXPECT_THAT(complaint([&] { Channel<double>(s, MPI_COMM_WORLD); }),
              AllOf(HasSubstr("'time.step'"), HasSubstr("0.3272")));
}

TEST(UserMistakes, AStepPastTheCflLimitIsRefusedAtTheStartAndOnTheWay) {
  Settings s = box({8, 8, 8}, 0.125, 1e-3, 0.25);
  set_y_ends(s, Wall::free_slip, Wall::free_slip);
  s.start.from = Start::laminar;
  s.start.velocity = 1.0;  // CFL 2
  EXPECT_THAT(complaint([&] { Channel<double>(s, MPI_COMM_WORLD); }),
              AllOf(HasSubstr("step 0"), HasSubstr("CFL"), HasSubstr("0.2165")));
  s.start.velocity = 0.8;  // CFL 1.6, and the pressure gradient speeds it up by 0.05 a step
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 0.2;
  Channel<double> channel(s, MPI_COMM_WORLD);
  EXPECT_NEAR(channel.cfl(), 1.6, 1e-12);
  EXPECT_THAT(complaint([&] { advance(channel, 10); }),
              AllOf(HasSubstr("step 2"), HasSubstr("CFL")));
  // Without convection there is no such limit.
  s.fluid.convection = false;
  EXPECT_EQ(complaint([&] {
              Channel<double> stokes(s, MPI_COMM_WORLD);
              advance(stokes, 10);
            }),
            "");
}

TEST(UserMistakes, AFieldThatIsNotFiniteStopsTheRunAtOnceWithItsPlace) {
  Settings s = box({8, 8, 8}, 0.125, 1e-3, 0.01);
  Channel<double> channel(s, MPI_COMM_WORLD);
  const Decomposition& decomposition = channel.decomposition();
  const int plane = 5, row = 2;
  if (decomposition.holds(plane, row))
    channel.fields_to_restore()[Stored::velocity].row(plane - decomposition.first(),
                                                      row - decomposition.first_row(), 1)[3] =
        std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(
      complaint([&] { advance(channel, 1); }),
      AllOf(HasSubstr("step 0"), HasSubstr("not finite"),
            ContainsRegex("near cell .[234], [456], [123].")) /* (3, 5, 2) or a neighbour */);
}

/// Markers need cubes up to two cells above a sphere. Cubes of 0.25 up to 1.5: a sphere may reach
/// 1.0.
TEST(UserMistakes, SpheresThatReachStretchedCellsAreRefused) {
  Settings s = box({8, 10, 8}, 0.25, 0.1, 0.01);
  s.grid.length[1] = 3.0;
  s.grid.y_uniform = 1.5;
  const auto said = [&](double top) {
    SphereState sphere;
    sphere.tag = 7;
    sphere.radius = 0.375;
    sphere.position = {1.0, top - sphere.radius, 1.0};
    return complaint([&] { Channel<double>(s, MPI_COMM_WORLD, {{sphere}}); });
  };
  EXPECT_EQ(said(1.0), "");
  const std::string sentence = said(1.001);
  for (const char* part : {"test.toml", "sphere 7", "y = 1.001", "below 1;", "'grid.y_uniform'"})
    EXPECT_THAT(sentence, HasSubstr(part));
  s.grid.length[1] = 2.5;  // cubes everywhere
  s.grid.y_uniform = 0.0;
  EXPECT_EQ(said(2.0), "");
}

/// Between x walls the pressure on them takes momentum: no residual, rather than a perfect one.
TEST(MomentumResidual, IsNotANumberBetweenXWalls) {
  Settings s = box({8, 8, 8}, 0.25, 0.1, 0.01);
  s.start.from = Start::rest;
  for (const bool walls : {false, true}) {
    s.boundary.x = walls ? no_slip : periodic;
    Channel<double> channel(s, MPI_COMM_WORLD);
    advance(channel, 1);
    EXPECT_EQ(std::isnan(channel.momentum_residual()), walls);
  }
}

/// With time.cfl the step follows the flow: as long as allowed, up to one rung of its ladder.
TEST(TimeStep, FollowsTheCflNumber) {
  Settings s = box({24, 16, 20}, 1.0 / 16, 1e-3, 0.2);
  disturb(s, 1.0, 0.4);
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 0.2;
  s.time.cfl = 1.2;
  Channel<double> channel(s, MPI_COMM_WORLD);
  double passed = 0.0;
  std::set<double> lengths;
  for (int n = 0; n < 60; ++n) {
    EXPECT_LE(channel.cfl(), 1.2 * (1 + 1e-12));
    EXPECT_GT(channel.cfl(), 1.2 / std::exp2(1.0 / 16) * (1 - 1e-12));
    passed += channel.time_step();
    lengths.insert(channel.time_step());
    advance(channel, 1);
  }
  EXPECT_NEAR(channel.time(), passed, 1e-12);
  EXPECT_GE(lengths.size(), 3u);   // the flow is driven faster and faster
  EXPECT_LE(lengths.size(), 20u);  // and changes its step seldom
  // The driving force is what speeds it up, whatever the steps.
  EXPECT_LT(std::abs(channel.momentum_residual()), 1e-13);
  // At rest nothing but time.step and diffusion limit it: 2.5127 h^2 / (12 nu).
  s.start.from = Start::rest;
  s.time.step = 2.0;
  EXPECT_NEAR(Channel<double>(s, MPI_COMM_WORLD).time_step(), 0.8179, 0.035);
  s.time.step = 0.3;
  EXPECT_EQ(Channel<double>(s, MPI_COMM_WORLD).time_step(), 0.3);
}

/// On stretched y the speed through a face counts by the lower one of the cells beside it, and
/// explicit diffusion is limited by the lowest of all, at whichever wall.
TEST(TimeStep, KnowsTheHeightsOfCells) {
  for (const bool dense_above : {false, true}) {
    Settings s = box({8, 8, 8}, 0.125, 0.01, 1e-4);
    s.boundary.y = dense_above ? under_a_lid : open_channel;
    s.grid.y_stretching = 1.5;
    const Grid grid = make_grid(s);
    const double lowest = grid.thickness(dense_above ? 7 : 0);
    ASSERT_LT(lowest, 0.5 * grid.thickness(dense_above ? 0 : 7));
    // The second differences of a wave that changes sign from cell to cell: 4 (2/h^2 + 1/dy^2).
    EXPECT_NEAR(explicit_diffusion_limit(grid, 0.01) * 0.01 * 4.0 *
                    (2.0 + 1.0 / (lowest * lowest)) / (0.125 * 0.125),
                2.5127453266183286, 1e-12);
    const Decomposition decomposition(grid, MPI_COMM_WORLD);
    for (int j = 0; j < 7; ++j) {
      Field<double> velocity(grid, decomposition.extent(), 3);
      if (decomposition.holds(j, 3))
        velocity.row(j - decomposition.first(), 3 - decomposition.first_row(), 1)[5] = -2.0;
      const double beside = grid.thickness(dense_above ? j + 1 : j);
      EXPECT_DOUBLE_EQ(all_max(largest_local_speed(velocity, grid, decomposition), MPI_COMM_WORLD),
                       2.0 / beside);
      EXPECT_EQ(find_fastest(velocity, grid, decomposition), (std::array{5, j, 3}));
    }
  }
}

/// The clock of the phases sees the stages, all of them and nothing else.
TEST(Phases, AddUpToTheStages) {
  Settings s = box({32, 24, 32}, 1.0 / 16, 1e-3, 0.005);
  disturb(s, 1.0, 0.1);
  Channel<double> channel(s, MPI_COMM_WORLD);
  for (const double seconds : channel.clock().seconds()) EXPECT_EQ(seconds, 0.0);
  const double begin = MPI_Wtime();
  advance(channel, 5);
  const double elapsed = MPI_Wtime() - begin;
  double sum = 0.0;
  for (const double seconds : channel.clock().seconds()) {
    EXPECT_GT(seconds, 0.0);
    sum += seconds;
  }
  EXPECT_LE(sum, elapsed);
}

TEST(Phases, HaveTheirTrafficAndItsShareOfTheBandwidth) {
  PhaseClock clock;
  clock.start();
  clock.lap(FlowPhase::momentum);
  const auto rows =
      phase_rows(clock, {.cells = 1000.0, .stages = 30.0, .real_bytes = 8}, MPI_COMM_SELF);
  double bytes = 0.0;
  for (const PhaseRow& row : rows) bytes += row.bytes_per_cell;
  // Eight bytes times 10 (momentum), 1 + 1 (elimination, substitution), 6 + 1/3 (correction).
  EXPECT_NEAR(bytes, 8.0 * (10.0 + 2.0 + 6.0 + 1.0 / 3.0), 1e-9);
  EXPECT_EQ(rows[0].bytes_per_cell, 80.0);
  EXPECT_NEAR(rows[0].gb_per_s, 80e-9 * 30e3 / rows[0].seconds, 1e-9 * rows[0].gb_per_s);
  EXPECT_NEAR(rows[0].ns_per_cell, 1e9 * rows[0].seconds / 30e3, 1e-9);
  const std::vector<PhaseRow> made_up{{"momentum", 2.0, 4.0, 80.0, 20.0}};
  EXPECT_THAT(phase_table(made_up, 40.0), AllOf(HasSubstr("50%"), HasSubstr("40.0 GB/s")));
  EXPECT_THAT(phase_table(made_up, 0.0), testing::Not(HasSubstr("bandwidth")));
}

/// Convection off: the velocity of a uniform stream plus a shear wave must not move.
TEST(Convection, OffLeavesTheStokesEquations) {
  const double nu = 0.02, k = 2.0 * M_PI;
  Settings s = box({16, 16, 4}, 1.0 / 16, nu, 0.005);
  set_y_ends(s, Wall::periodic, Wall::periodic);
  const auto wave = [&](int c, const Vec3& x) {
    return c == 0 ? 1.0 : c == 1 ? 0.5 * std::sin(k * x[0]) : 0.0;
  };
  // Discrete decay rate of the wave: nu (2 sin(k h/2)/h)^2.
  const double rate = nu * std::pow(2.0 * std::sin(0.5 * k / 16) * 16, 2);
  for (const bool convection : {false, true}) {
    s.fluid.convection = convection;
    Channel<double> channel(s, MPI_COMM_WORLD);
    channel.set_velocity(wave);
    advance(channel, 40);
    const double size = std::exp(-rate * channel.time());
    const double error = largest_error<double>(
        channel, [&](int c, const Vec3& x) { return c == 1 ? size * wave(c, x) : wave(c, x); });
    // Third-order time error of the decay: (rate dt)^3 per unit rate t, about 1e-8.
    if (!convection) EXPECT_LT(error, 1e-7);
    if (convection) EXPECT_GT(error, 0.3);  // carried 0.2 of a wave length along
  }
}

TEST(StartField, ProfilesHaveTheirMeanAndShape) {
  Settings s = box({8, 64, 8}, 1.0 / 64, 1.0 / 4449.0, 1e-3);
  s.start.velocity = 1.4;
  s.start.height = 0.25;
  for (const Start kind : {Start::laminar, Start::logarithmic}) {
    s.start.from = kind;
    const Grid grid = make_grid(s);
    const StartProfile profile(s, grid);
    EXPECT_EQ(profile(0.2), 0.0);
    double mean = 0.0;
    for (int n = 0; n < 3000; ++n) mean += profile(0.25 + 0.75 * (n + 0.5) / 3000) / 3000;
    EXPECT_NEAR(mean, 1.4, 1e-3);
    EXPECT_GT(profile(0.99), profile(0.6));
  }
  // Re = 1.4 * 0.75 * 4449 = 4671 over the depth: a friction velocity near 1/17 of the mean.
  s.start.from = Start::logarithmic;
  const StartProfile profile(s, make_grid(s));
  const double slope = profile(0.25 + 1e-5) / 1e-5;
  EXPECT_NEAR(std::sqrt(slope / 4449.0) / 1.4, 1.0 / 16.5, 0.005);
  // A viscous flow, whose friction velocity is above its own.
  s.fluid.kinematic_viscosity = 10.0;
  const StartProfile viscous(s, make_grid(s));
  double mean = 0.0;
  for (int n = 0; n < 3000; ++n) mean += viscous(0.25 + 0.75 * (n + 0.5) / 3000) / 3000;
  EXPECT_NEAR(mean, 1.4, 1e-3);
}

TEST(StartField, LaminarFlowBetweenMovingWallsIsLinearAlongBoth) {
  Settings s = box({8, 16, 8}, 1.0 / 16, 1e-2, 1e-3);
  s.start.from = Start::laminar;
  set_y_ends(s, Wall::no_slip, Wall::no_slip);
  s.boundary.y_lower_velocity = {0.2, 0.0, -0.3};
  s.boundary.y_upper_velocity = {1.0, 0.0, 0.5};
  const StartProfile profile(s, make_grid(s));
  EXPECT_NEAR(profile(0.25), 0.4, 1e-12);
  EXPECT_NEAR(profile.across(0.25), -0.1, 1e-12);
  set_y_ends(s, Wall::no_slip, Wall::free_slip);
  s.boundary.y_upper_velocity = {};
  EXPECT_NEAR(StartProfile(s, make_grid(s)).across(0.25), -0.3, 1e-12);
}

TEST(StartField, LaminarFlowBetweenMovingZWallsIsLinearWhereNoYWallHoldsIt) {
  Settings s = box({8, 16, 8}, 1.0 / 16, 1e-2, 1e-3);
  s.start.from = Start::laminar;
  s.boundary.z = {Wall::no_slip, Wall::no_slip};
  s.boundary.z_lower_velocity = {0.2, -0.4, 0.0};
  s.boundary.z_upper_velocity = {1.0, 0.6, 0.0};
  const auto at_quarter = [&](Wall lower, Wall upper) {
    set_y_ends(s, lower, upper);
    const Grid grid = make_grid(s);
    return StartProfile(s, grid).between_z_walls(0.25 * grid.length[2]);
  };
  const std::array<double, 2> through = at_quarter(Wall::periodic, Wall::periodic);
  EXPECT_NEAR(through[0], 0.4, 1e-12);
  EXPECT_NEAR(through[1], -0.15, 1e-12);
  // Both directions are steady flows: nothing is left to develop.
  Channel<double> channel(s, MPI_COMM_WORLD);
  const double before = channel.kinetic_energy();
  EXPECT_GT(before, 0.0);
  advance(channel, 20);
  EXPECT_NEAR(channel.kinetic_energy(), before, 1e-10 * before);
  // What goes along y has no way through its ends.
  EXPECT_EQ(at_quarter(Wall::free_slip, Wall::free_slip), (std::array{through[0], 0.0}));
  EXPECT_EQ(at_quarter(Wall::no_slip, Wall::free_slip), (std::array{0.0, 0.0}));
  s.boundary.z = {Wall::free_slip, Wall::no_slip};
  s.boundary.z_lower_velocity = {};
  EXPECT_EQ(at_quarter(Wall::free_slip, Wall::free_slip), (std::array{1.0, 0.0}));
}

/// Disturbances have about the size asked for, in every component, and another seed gives others.
TEST(StartField, DisturbancesHaveTheirSize) {
  Settings s = box({32, 24, 24}, 1.0 / 16, 1e-3, 0.005);
  disturb(s, 2.0, 0.0);
  Channel<double> calm(s, MPI_COMM_WORLD);
  s.start.disturbance = 0.1;
  Channel<double> first(s, MPI_COMM_WORLD);
  s.start.seed = 2;
  Channel<double> second(s, MPI_COMM_WORLD);
  EXPECT_LT(first.max_divergence(), 1e-12);
  const auto rms = [&](const Channel<double>& a, const Channel<double>& b, int c) {
    double sum = 0.0;
    for (int j = 0; j < a.decomposition().planes(); ++j)
      for (int k = 0; k < a.decomposition().rows(); ++k)
        for (int i = 0; i < 32; ++i)
          sum += std::pow(a.velocity().row(j, k, c)[i] - b.velocity().row(j, k, c)[i], 2);
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    return std::sqrt(sum / a.grid().cell_count());
  };
  for (int c = 0; c < 3; ++c) {
    EXPECT_GT(rms(first, calm, c), 0.1 * 0.2) << c;  // amplitude 0.1 * 2
    EXPECT_LT(rms(first, calm, c), 1.0 * 0.2) << c;
    EXPECT_GT(rms(first, second, c), 0.1 * 0.2) << c;
  }
}

/// A start that is disturbed by a tenth becomes turbulent and stays so: from 25 to 40 half heights
/// over the bulk velocity its wall stress is that of turbulence, whichever profile it began from.
/// Left alone, the parabola stays what it is.
TEST(StartField, BecomesTurbulent) {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  if (ranks > 1) GTEST_SKIP() << "chaotic, and the same on any number of ranks";
  const double nu = 1.0 / 2800.0;
  Settings s = box({64, 32, 32}, 2.0 / 32, nu, 0.1);
  set_y_ends(s, Wall::no_slip, Wall::no_slip);
  s.time.cfl = 1.5;
  s.flow.driving = Driving::bulk_velocity;
  s.flow.bulk_velocity = s.start.velocity = 1.0;
  const auto friction = [&](Start profile, double disturbance, double from, double to) {
    s.start.from = profile;
    s.start.disturbance = disturbance;
    Channel<float> channel(s, MPI_COMM_WORLD);
    double sum = 0.0, time = 0.0;
    while (channel.time() < to) {
      advance(channel, 1);
      if (channel.time() < from) continue;
      sum += channel.last_time_step() * channel.driving_force();
      time += channel.last_time_step();
    }
    return std::sqrt(sum / time);  // density and half height are 1
  };
  const double laminar = std::sqrt(3.0 * nu);  // 0.0327; turbulent: 0.064 (Re_tau = 180)
  EXPECT_NEAR(friction(Start::laminar, 0.0, 5.0, 10.0), laminar, 0.002);
  for (const Start profile : {Start::laminar, Start::logarithmic}) {
    const double turbulent = friction(profile, 0.1, 25.0, 40.0);
    EXPECT_GT(turbulent, 0.058);  // three times the laminar stress
    EXPECT_LT(turbulent, 0.085);  // a grid this coarse overshoots
  }
}

/// The old pressure gradient in the predictor, once a sphere has been there, against none: without
/// forcing in between, the projection yields the same velocity, and the summed-up pressure is the
/// same as the one solved for anew. So where it is in all planes, and where in the lowest alone.
template <class Meet, class Advance>
void expect_same_as_solved_anew(Meet meet_spheres, Advance advance_summed,
                                Wall y_ends = Wall::no_slip) {
  Settings s = box({16, 12, 12}, 1.0 / 12, 1e-3, 0.01);
  set_y_ends(s, y_ends, y_ends);
  disturb(s, 1.0, 0.3);
  s.flow.driving = Driving::bulk_velocity;
  s.flow.bulk_velocity = 1.0;
  s.spheres.pressure_share = 1.0;  // or the sum lags behind
  Channel<double> anew(s, MPI_COMM_WORLD), summed(s, MPI_COMM_WORLD);
  meet_spheres(summed);
  advance(anew, 5);
  advance_summed(summed);
  double velocity = 0.0, pressure = 0.0, largest = 0.0;
  for (int j = 0; j < anew.decomposition().planes(); ++j)
    for (int k = 0; k < anew.decomposition().rows(); ++k)
      for (int i = 0; i < 16; ++i) {
        for (int c = 0; c < 3; ++c)
          velocity = std::max(velocity, std::abs(anew.velocity().row(j, k, c)[i] -
                                                 summed.velocity().row(j, k, c)[i]));
        const double p = anew.pressure().row(j, k)[i];
        largest = std::max(largest, std::abs(p));
        pressure = std::max(pressure, std::abs(p - summed.pressure().row(j, k)[i]));
      }
  EXPECT_LT(all_max(velocity, MPI_COMM_WORLD), 100 * epsilon<double>());
  EXPECT_GT(all_max(largest, MPI_COMM_WORLD), 0.01);
  // Round-off of u* over the stage step of 0.0013, fifteen of them summed up.
  EXPECT_LT(all_max(pressure, MPI_COMM_WORLD), 1e5 * epsilon<double>());
}

TEST(Pressure, SummedUpAndSolvedAnewAreTheSame) {
  const auto met = [](Channel<double>& summed) {
    const std::vector<SphereState> one{{.tag = 1, .position = {0.5, 0.4, 0.5}, .radius = 0.25}};
    summed.set_spheres(one);
    summed.set_spheres({});
  };
  expect_same_as_solved_anew(met, [](Channel<double>& summed) { advance_in_parts(summed, 5); });
  expect_same_as_solved_anew(met, [](Channel<double>& summed) { advance(summed, 5); });
  // Spheres that a script will insert: none has been there yet.
  const auto waited_for = [](Channel<double>& summed) {
    summed.move_spheres({}, summed.time_step());
  };
  for (const Wall y_ends : {Wall::no_slip, Wall::periodic})
    expect_same_as_solved_anew(
        waited_for, [](Channel<double>& summed) { advance(summed, 5); }, y_ends);
}

/// A state of another run brings the force that kept that run's bulk velocity; a run that is driven
/// otherwise, or not at all, does not take it over.
TEST(Restart, IsDrivenAsItsOwnSettingsSay) {
  for (const auto [driving, gradient] :
       {std::pair{Driving::none, 0.0}, std::pair{Driving::pressure_gradient, 0.3}}) {
    Settings s = box({8, 8, 8}, 1.0 / 8, 1e-3, 0.01);
    set_y_ends(s, Wall::periodic, Wall::periodic);
    s.fluid.density = 2.0;
    s.flow.driving = driving;
    s.flow.pressure_gradient = gradient;
    Channel<double> channel(s, MPI_COMM_WORLD);
    channel.restored(0.0, 0, 7.0, false);
    Settings other = s;
    other.flow.driving = Driving::pressure_gradient;
    other.flow.pressure_gradient = 5.0;
    Channel<double> before(other, MPI_COMM_WORLD);
    const test::Folder folder;
    test::carry_over(before, channel, folder / "channel.h5", MPI_COMM_WORLD);
    EXPECT_EQ(channel.driving_force(), gradient);
    advance(channel, 10);
    // Without walls all of the force speeds up: du = G t / rho.
    EXPECT_NEAR(channel.bulk_velocity(), gradient / 2.0 * 0.1, 1e-14);
  }
}

/// Couette flow from rest in single precision, nu dt/h^2 = 400 and 800: the balance of momentum is
/// off by more than the rounding of a sum, and by no more than its bound for such steps.
TEST(Momentum, IsBalancedToTheRoundingOfLongImplicitSteps) {
  for (const double length : {400.0, 800.0}) {
    const double h = 1.0 / 16, dt = h;
    Settings s = box({16, 16, 16}, h, length * h * h / dt, dt);
    set_y_ends(s, Wall::no_slip, Wall::no_slip);
    s.boundary.y_upper_velocity = {1.0, 0.0, 0.0};
    s.fluid.diffusion = Diffusion::implicit;
    s.flow.driving = Driving::none;
    Channel<float> channel(s, MPI_COMM_WORLD);
    double largest = 0.0;
    for (int n = 0; n < 5; ++n) {
      advance(channel, 1);
      largest = std::max(largest, std::abs(channel.momentum_residual()));
    }
    EXPECT_GT(largest, 1e-6) << "no need of this bound";
    EXPECT_LT(largest, channel.momentum_rounding());
    EXPECT_LT(channel.momentum_rounding(), 20 * largest);
    EXPECT_NEAR(channel.bulk_velocity(), 0.5, 4e-3);  // it still rings, as in double
  }
}

/// A state with another bulk velocity is another start: what brings it there drives nothing.
TEST(Restart, IsShiftedToItsBulkVelocity) {
  Settings s = box({8, 8, 8}, 1.0 / 8, 1e-3, 0.01);
  s.flow.driving = Driving::bulk_velocity;
  s.start.velocity = s.flow.bulk_velocity = 1.0;
  const Channel<double> slow(s, MPI_COMM_WORLD);
  s.flow.bulk_velocity = 1.2;
  Channel<double> fast(s, MPI_COMM_WORLD);
  for (int j = 0; j < slow.decomposition().planes(); ++j)
    std::copy_n(slow.velocity().plane(j), slow.velocity().plane_size(),
                fast.fields_to_restore()[Stored::velocity].plane(j));
  fast.shift_to_bulk_velocity();
  fast.restored(0.0, 0, 0.0, false);
  EXPECT_NEAR(fast.bulk_velocity(), 1.2, 1e-14);
  EXPECT_NEAR(fast.velocity().row(2, 2, 0)[3] - slow.velocity().row(2, 2, 0)[3], 0.2, 1e-14);
  advance(fast, 1);
  EXPECT_LT(std::abs(fast.driving_force()), 0.5) << "0.2 in a step of 0.01 would be 20";
}

/// A run that goes on from its own velocity and pressure is the same run.
TEST(Restart, GoesOnAsIfNothingHadHappened) {
  Settings s = box({16, 12, 12}, 1.0 / 12, 1e-3, 0.01);
  disturb(s, 1.0, 0.3);
  s.flow.driving = Driving::bulk_velocity;
  s.flow.bulk_velocity = 1.0;
  const std::vector<SphereState> spheres{
      {.tag = 1, .position = {0.5, 0.4, 0.5}, .radius = 0.25, .mobile = false}};
  Channel<double> whole(s, MPI_COMM_WORLD, spheres), again(s, MPI_COMM_WORLD, spheres);
  advance_in_parts(whole, 3);
  for (int j = 0; j < whole.decomposition().planes(); ++j) {
    std::copy_n(whole.velocity().plane(j), whole.velocity().plane_size(),
                again.fields_to_restore()[Stored::velocity].plane(j));
    std::copy_n(whole.pressure().plane(j), whole.pressure().plane_size(),
                again.fields_to_restore()[Stored::pressure].plane(j));
  }
  again.restored(whole.time(), whole.step(), whole.driving_force(), false);
  advance_in_parts(whole, 3);
  advance_in_parts(again, 3);
  EXPECT_EQ(again.step(), 6);
  EXPECT_EQ(again.time(), whole.time());
  double largest = 0.0;
  for (int j = 0; j < whole.decomposition().planes(); ++j)
    for (int k = 0; k < whole.decomposition().rows(); ++k)
      for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 16; ++i)
          largest = std::max(largest, std::abs(whole.velocity().row(j, k, c)[i] -
                                               again.velocity().row(j, k, c)[i]));
  // The pressure above the slab is summed up there, or comes from the neighbour: equal to
  // round-off.
  EXPECT_LT(all_max(largest, MPI_COMM_WORLD), 100 * epsilon<double>());
}

}  // namespace
}  // namespace bedload
