// One forcing of a given velocity field: momentum, slip, ranks, seams, walls, contact.

#include <gtest/gtest.h>
#include <mpi.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/immersed_boundary/gather.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"
#include "fluid/immersed_boundary/marker_volume.hpp"
#include "fluid/settings/errors.hpp"
#include "tests/fluid/splits.hpp"

namespace bedload {
namespace {

Settings small_box() {
  Settings settings;
  settings.grid.cells = {24, 20, 16};
  settings.grid.length = {2.4, 2.0, 1.6};
  settings.fluid.density = 1.7;
  settings.fluid.kinematic_viscosity = 0.01;
  settings.spheres.forcing_loops = 1;
  return settings;
}

SphereState sphere(std::int64_t tag, const Vec3& position, bool mobile, double radius = 0.4) {
  return {.tag = tag,
          .position = position,
          .velocity = Vec3::Zero(),
          .angular_velocity = Vec3::Zero(),
          .radius = radius,
          .mobile = mobile};
}

/// A flow on one communicator: the whole box for MPI_COMM_SELF, a block of it for MPI_COMM_WORLD,
/// `z_parts` of them side by side along z.
template <class Real>
struct Flow {
  Settings settings;
  Grid grid;
  Decomposition decomposition;
  Field<Real> velocity;
  ImmersedBoundary<Real> boundary;

  Flow(const Settings& s, MPI_Comm comm, int z_parts = 1)
      : settings(s),
        grid(make_grid(s)),
        decomposition(grid, comm, even_cuts(grid, size_of(comm), z_parts)),
        velocity(grid, decomposition.extent(), 3),
        boundary(settings, grid, decomposition) {}

  /// u_c = f(c, x) with periodic and rank ghosts.
  template <class Function>
  void fill(Function f) {
    for (int j = 0; j < decomposition.planes(); ++j) {
      for (int k = 0; k < decomposition.rows(); ++k)
        for (int c = 0; c < 3; ++c)
          for (int i = 0; i < grid.cells[0]; ++i) {
            const int plane = decomposition.first() + j, row = decomposition.first_row() + k;
            const Vec3 x{c == 0 ? grid.face(i) : grid.centre(i),
                         c == 1 ? grid.face(plane) : grid.centre(plane),
                         c == 2 ? grid.face(row) : grid.centre(row)};
            velocity.row(j, k, c)[i] = static_cast<Real>(f(c, x));
          }
      wrap_x_ghosts(velocity, j);
    }
    decomposition.exchange(velocity);
  }
  ForcingReport force(double dt, bool measure = false) { return force(dt, measure, dt); }
  ForcingReport force(double dt, bool measure, double carry_time) {
    boundary.force(velocity, dt, carry_time, measure);
    return boundary.report();
  }
  /// Loads of the spheres of all ranks.
  std::vector<SphereLoad> loads(double dt) {
    return gather_by_tag<SphereLoad>(decomposition.comm(), boundary.loads(dt));
  }
  /// Sum over all cells of all ranks.
  Vec3 sum() const {
    Vec3 total = Vec3::Zero();
    for (int j = 0; j < decomposition.planes(); ++j)
      for (int k = 0; k < decomposition.rows(); ++k)
        for (int c = 0; c < 3; ++c)
          for (int i = 0; i < grid.cells[0]; ++i)
            total[c] += static_cast<double>(velocity.row(j, k, c)[i]);
    MPI_Allreduce(MPI_IN_PLACE, total.data(), 3, MPI_DOUBLE, MPI_SUM, decomposition.comm());
    return total;
  }
};

/// Smooth, without symmetry, periodic in x and z.
double wavy(int c, const Vec3& x) {
  const double a = 2.0 * std::numbers::pi * x.x() / 2.4, b = 2.0 * std::numbers::pi * x.z() / 1.6;
  return 1.0 + 0.3 * c + 0.5 * std::sin(a + c) * std::cos(2.0 * x.y()) + 0.2 * std::cos(b - c);
}

std::vector<SphereState> spheres_everywhere() {
  std::vector<SphereState> all{
      sphere(1, {0.05, 1.02, 1.58}, true),    // across both seams and the middle of y
      sphere(2, {1.2, 0.38, 0.8}, false),     // on the floor, cut by it
      sphere(3, {1.3, 1.9, 0.4}, true),       // half beyond the free-slip top
      sphere(4, {1.95, 0.41, 0.77}, false),   // touches 2 nearly
      sphere(5, {1.57, 1.0633, 0.79}, true),  // sits on 2 and 4, overlapping by 2 per cent
      sphere(6, {0.53, 0.6, 0.3}, true, 0.25)};
  all[0].velocity = {0.5, -0.3, 0.2};
  all[0].angular_velocity = {1.0, 2.0, -1.5};
  all[4].angular_velocity = {-2.0, 0.4, 0.6};
  return all;
}

TEST(Forcing, GivesTheFluidExactlyTheMarkersMomentum) {
  Flow<double> flow(small_box(), MPI_COMM_WORLD);
  flow.fill(wavy);
  flow.boundary.set_spheres(spheres_everywhere());
  const Vec3 before = flow.sum();
  const double dt = 0.013;
  flow.boundary.start_stage(flow.velocity);
  const ForcingReport report = flow.force(dt);
  const Vec3 gained = (flow.sum() - before) * 1.7 * flow.grid.cell_volume() / dt;
  ASSERT_GT(gained.norm(), 1.0) << "a force that vanishes would pass what follows";
  // Sums of some 10^4 numbers of order 1: round-off 1e-12 of the result.
  EXPECT_LT((gained - report.force_on_fluid).norm(), 1e-11 * gained.norm());
}

TEST(Forcing, LoadsAreTheReactionPlusInteriorAndBuoyancy) {
  Settings settings = small_box();
  settings.fluid.gravity = {0.0, -9.0, 0.0};
  Flow<double> flow(settings, MPI_COMM_WORLD);
  flow.fill([](int c, const Vec3&) { return c == 0 ? 1.0 : 0.0; });
  std::vector<SphereState> all{sphere(7, {2.35, 1.0, 0.1}, true)};
  flow.boundary.set_spheres(all);
  flow.boundary.start_stage(flow.velocity);
  const double dt = 0.02;
  const ForcingReport report = flow.force(dt);
  const double volume = 4.0 / 3.0 * std::numbers::pi * 0.064;
  const std::vector<SphereLoad> loads = flow.loads(dt);
  ASSERT_EQ(loads.size(), 1u);
  EXPECT_EQ(loads[0].tag, 7);
  // The flow is stopped at the markers: the fluid loses, the sphere gains, and what the fluid
  // inside lost comes off.
  EXPECT_LT(report.force_on_fluid.x(), 0.0);
  const double lost_inside = volume * 1.7 / dt * 1.0;  // if all of it were stopped
  EXPECT_GT(loads[0].force.x(), 0.0);
  EXPECT_LT(loads[0].force.x(), -report.force_on_fluid.x());
  EXPECT_GT(loads[0].force.x(), -report.force_on_fluid.x() - lost_inside);
  EXPECT_NEAR(loads[0].force.y(), 1.7 * volume * 9.0, 1e-9) << "buoyancy, upwards";
  EXPECT_NEAR(report.force_on_fluid.y(), 0.0, 1e-9);
}

TEST(Forcing, InteriorTermAndBuoyancyCanBeLeftOut) {
  const double dt = 0.02, volume = 4.0 / 3.0 * std::numbers::pi * 0.064;
  const auto load = [&](bool interior, bool buoyancy, Vec3& reaction) {
    Settings settings = small_box();
    settings.fluid.gravity = {0.0, -9.0, 0.0};
    settings.spheres.interior_term = interior;
    settings.spheres.buoyancy = buoyancy;
    Flow<double> flow(settings, MPI_COMM_WORLD);
    flow.fill([](int c, const Vec3&) { return c == 0 ? 1.0 : 0.0; });
    flow.boundary.set_spheres(std::vector<SphereState>{sphere(7, {2.35, 1.0, 0.1}, true)});
    flow.boundary.start_stage(flow.velocity);
    reaction = -flow.force(dt).force_on_fluid;
    return flow.loads(dt).at(0).force;
  };
  Vec3 with, without;
  const Vec3 both = load(true, true, with), bare = load(false, false, without);
  EXPECT_EQ(with, without) << "the fluid gets the same";
  EXPECT_NEAR((bare - without).norm(), 0.0, 1e-9 * without.norm()) << "the markers' reaction alone";
  EXPECT_NEAR(both.y() - bare.y(), 1.7 * volume * 9.0, 1e-9);
  // A tenth to all of the fluid inside is stopped within the stage.
  EXPECT_LT(both.x() - bare.x(), -0.1 * volume * 1.7 / dt);
}

TEST(Forcing, AFluidThatMovesWithTheSphereFeelsNothing) {
  Flow<double> flow(small_box(), MPI_COMM_WORLD);
  std::vector<SphereState> all{sphere(7, {1.21, 1.03, 0.83}, true)};
  all[0].velocity = {0.4, -0.2, 0.1};
  all[0].angular_velocity = {1.5, -0.7, 2.2};
  flow.fill([&all](int c, const Vec3& x) {
    return (all[0].velocity + all[0].angular_velocity.cross(x - all[0].position))[c];
  });
  flow.boundary.set_spheres(all);
  flow.boundary.start_stage(flow.velocity);
  const ForcingReport report = flow.force(0.01, true);
  EXPECT_LT(report.before.max, 1e-12) << "the kernel interpolates linear fields exactly";
  const SphereLoad load = flow.loads(0.01).at(0);
  EXPECT_LT(load.force.norm(), 1e-8);
  EXPECT_LT(load.torque.norm(), 1e-8);
}

TEST(Forcing, ATurningSphereIsBrakedAboutItsOwnAxis) {
  for (int axis = 0; axis < 3; ++axis) {
    Flow<double> flow(small_box(), MPI_COMM_WORLD);
    std::vector<SphereState> all{sphere(7, {1.21, 1.03, 0.83}, true)};
    all[0].angular_velocity[axis] = 2.0;
    flow.fill([](int, const Vec3&) { return 0.0; });
    flow.boundary.set_spheres(all);
    flow.boundary.start_stage(flow.velocity);
    const double dt = 0.01;
    flow.boundary.force(flow.velocity, dt, dt);
    const SphereLoad load = flow.loads(dt).at(0);
    // An even slip is met by about two cells' depth of fluid around the surface (the row sums
    // return half): torque -rho omega (2/3 r^2) 4 pi r^2 (2h) / dt. The half that lies inside is
    // not felt, and of the rest the sphere gets a half in the first stage.
    const double r = 0.4 - (0.29 + 0.125) * 0.1;
    const double shell =
        1.7 * 2.0 * (2.0 / 3.0 * r * r) * 4.0 * std::numbers::pi * r * r * 0.2 / dt;
    EXPECT_LT(load.torque[axis], -0.125 * shell);
    EXPECT_GT(load.torque[axis], -0.3 * shell);
    Vec3 others = load.torque;
    others[axis] = 0.0;
    EXPECT_LT(others.norm(), 0.01 * std::abs(load.torque[axis]));
    EXPECT_LT(load.force.norm(), 0.04 * std::abs(load.torque[axis]) / r);
  }
}

TEST(Forcing, AngularMomentumGivenIsThatOfTheField) {
  // Away from walls and seams, sum over cells of x cross change = sum over markers of the same.
  Flow<double> flow(small_box(), MPI_COMM_WORLD);
  std::vector<SphereState> all{sphere(7, {1.21, 1.03, 0.83}, true)};
  all[0].angular_velocity = {1.0, -2.0, 0.5};
  all[0].velocity = {0.3, 0.1, -0.2};
  flow.fill([](int, const Vec3&) { return 0.0; });
  flow.boundary.set_spheres(all);
  flow.boundary.start_stage(flow.velocity);
  flow.boundary.force(flow.velocity, 1.0, 1.0);
  Vec3 angular = Vec3::Zero();
  for (int j = 0; j < flow.decomposition.planes(); ++j)
    for (int k = 0; k < flow.grid.cells[2]; ++k)
      for (int i = 0; i < flow.grid.cells[0]; ++i)
        for (int c = 0; c < 3; ++c) {
          const Grid& g = flow.grid;
          const int plane = flow.decomposition.first() + j;
          const Vec3 x{c == 0 ? g.face(i) : g.centre(i), c == 1 ? g.face(plane) : g.centre(plane),
                       c == 2 ? g.face(k) : g.centre(k)};
          Vec3 u = Vec3::Zero();
          u[c] = flow.velocity.row(j, k, c)[i];
          angular += (x - all[0].position).cross(u);
        }
  MPI_Allreduce(MPI_IN_PLACE, angular.data(), 3, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  angular *= 1.7 * flow.grid.cell_volume();
  // The load is half of (the rest is paid later) the reaction plus what the fluid inside gained;
  // with the fluid at rest before, that is the field's own interior momentum.
  InteriorCells interior;
  std::array<InteriorSums, 3> sums;
  for (int c = 0; c < 3; ++c)
    interior.add(flow.velocity, flow.grid, flow.decomposition, c, all[0].position, all[0].radius);
  for (std::size_t c = 0; c < 3; ++c) sums[c] = interior.sums(c, flow.velocity);
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sizeof sums / sizeof(double)),
                MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  // cells, x and xx were summed over ranks together with u: right for this fit, too.
  const InteriorMomentum inside = interior_momentum(sums, all[0].radius);
  const SphereLoad load = flow.loads(1.0).at(0);
  EXPECT_LT((2.0 * load.torque - (1.7 * inside.angular - angular)).norm(), 1e-11 * angular.norm());
  ASSERT_GT(angular.norm(), 0.01);
}

/// Between two mobile spheres three cells from each other, where no marker reaches, a point that
/// both may correct (dispersion_correction.hpp) gets the correction of the nearer one's motion
/// alone, and none where that one is fixed.
TEST(Forcing, CarriesTheLayerBetweenSpheresOnce) {
  for (const bool second_moves : {true, false}) {
    Flow<double> flow(small_box(), MPI_COMM_WORLD);
    std::vector<SphereState> all{sphere(1, {0.73, 1.04, 0.83}, true, 0.3),
                                 sphere(2, {1.63, 1.04, 0.83}, second_moves, 0.3)};
    all[0].velocity.y() = -0.9;
    if (second_moves) all[1].velocity.y() = 0.4;
    const auto wave = [](double y) { return std::cos(2.0 * std::numbers::pi / 0.6 * y); };
    flow.fill([&](int, const Vec3& x) { return wave(x.y()); });
    flow.boundary.set_spheres(all);
    flow.boundary.start_stage(flow.velocity);
    const double dt = 0.02, h = flow.grid.h;
    flow.boundary.force(flow.velocity, dt, dt);
    const int plane = 10, row = 8;
    if (!flow.decomposition.holds(plane, row)) continue;
    // q_j gets what the second differences D of the points above and below, at 1.4 to 1.8 h from
    // both surfaces, say: 1.25 V dt/(12 h) (D_j+1 - D_j-1). Face 11 is at x = 1.2, the middle
    // at 1.18.
    const auto at = [&](int n) { return wave(flow.grid.centre(plane + n)); };
    const double difference = at(2) - 2.0 * at(1) + 2.0 * at(-1) - at(-2);
    ASSERT_GT(std::abs(difference), 0.1);
    EXPECT_NEAR(flow.velocity.row(plane - flow.decomposition.first(),
                                  row - flow.decomposition.first_row(), 0)[11] -
                    at(0),
                1.25 * all[1].velocity.y() * dt / (12.0 * h) * difference, 1e-12);
  }
}

/// Once the last mobile sphere is gone the bed is forced as if there had never been one.
TEST(Forcing, FixedSpheresForgetTheMobileOnesThatAreGone) {
  const std::vector<SphereState> bed{sphere(2, {1.2, 0.38, 0.8}, false),
                                     sphere(4, {1.95, 0.41, 0.77}, false)};
  std::vector<SphereState> all = bed;
  all.push_back(sphere(5, {1.57, 1.0633, 0.79}, true));
  Flow<double> alone(small_box(), MPI_COMM_WORLD), left(small_box(), MPI_COMM_WORLD);
  alone.boundary.set_spheres(bed);
  left.boundary.set_spheres(all);
  const auto forced = [](Flow<double>& flow) {
    flow.fill(wavy);
    flow.boundary.start_stage(flow.velocity);
    return flow.force(0.01).force_on_fluid;
  };
  const Vec3 want = forced(alone);
  EXPECT_GT((forced(left) - want).norm(), 0.01 * want.norm());
  left.boundary.move_spheres({}, left.settings.time.step);
  EXPECT_LT((forced(left) - want).norm(), 1e-12 * want.norm());
}

TEST(Forcing, WhatTheProjectionDoesInsideReachesTheSphereInTheEnd) {
  // Between two stages the fluid inside gets a new motion (as by the projection), and the sphere
  // moves with it, so that no marker forces anything: the impulses of the following stages must sum
  // to the momentum that came in. A torque makes no excess spin in a fluid so viscous.
  Settings settings = small_box();
  settings.fluid.kinematic_viscosity = 1e6;
  Flow<double> flow(settings, MPI_COMM_WORLD);
  std::vector<SphereState> all{sphere(7, {1.21, 1.03, 0.83}, true)};
  flow.fill([](int, const Vec3&) { return 0.0; });
  flow.boundary.set_spheres(all);
  flow.boundary.start_stage(flow.velocity);
  flow.boundary.force(flow.velocity, 0.01, 0.01);
  flow.loads(0.01);
  all[0].velocity = {0.4, -0.2, 0.1};
  all[0].angular_velocity = {1.5, -0.7, 2.2};
  flow.fill([&all](int c, const Vec3& x) {
    return (all[0].velocity + all[0].angular_velocity.cross(x - all[0].position))[c];
  });
  Vec3 impulse = Vec3::Zero(), turn = Vec3::Zero();
  for (int stage = 0; stage < 300; ++stage) {
    flow.boundary.move_spheres(all, flow.settings.time.step);
    flow.boundary.start_stage(flow.velocity);
    flow.boundary.force(flow.velocity, 0.01, 0.01);
    const SphereLoad load = flow.loads(0.01).at(0);
    impulse += 0.01 * load.force;
    turn += 0.01 * load.torque;
  }
  const double mass = 1.7 * 4.0 / 3.0 * std::numbers::pi * 0.064;
  // Below 0.3 per cent: the fit's error for rotation (test_spheres_formulas.cpp).
  EXPECT_LT((impulse - mass * all[0].velocity).norm(), 3e-3 * impulse.norm());
  EXPECT_LT((turn - 0.4 * mass * 0.16 * all[0].angular_velocity).norm(), 3e-3 * turn.norm());
}

TEST(Forcing, OnceAStepTheReactionIsSharedWithTheAddedMass) {
  // Of the impulses of three stages a sphere that moves once per step gets m/(m + 2 m_f) behind the
  // last one, nothing before, and the rest later: the sum over steps is that of one that moves in
  // each stage.
  Settings by_step = small_box();
  by_step.coupling.exchange = Exchange::step;
  Flow<double> flow(by_step, MPI_COMM_WORLD), plain(small_box(), MPI_COMM_WORLD);
  std::vector<SphereState> all{sphere(7, {1.21, 1.03, 0.83}, true)};
  all[0].velocity = {0.4, -0.2, 0.1};
  all[0].density = 1.25 * small_box().fluid.density;
  const double share = 1.25 / 3.25;
  Vec3 due = Vec3::Zero(), given = Vec3::Zero();
  for (Flow<double>* f : {&flow, &plain}) {
    f->fill(wavy);
    f->boundary.set_spheres(all);
  }
  for (int stage = 0; stage < 12; ++stage) {
    const bool moves = stage % 3 == 2;
    for (Flow<double>* f : {&flow, &plain}) {
      f->boundary.start_stage(f->velocity);
      f->boundary.force(f->velocity, 0.01, 0.01);
    }
    const Vec3 impulse = plain.loads(0.01).at(0).force;
    const Vec3 paid =
        gather_by_tag<SphereLoad>(flow.decomposition.comm(), flow.boundary.loads(0.01, moves))
            .at(0)
            .force;
    due += impulse;
    EXPECT_LT((paid - (moves ? Vec3(share * due) : Vec3(Vec3::Zero()))).norm(),
              1e-12 * due.norm() + 1e-12);
    due -= paid;
    given += paid;
  }
  EXPECT_GT(given.norm(), 1.0);
}

TEST(Forcing, SpheresThatStayKeepTheirMarkers) {
  Flow<double> flow(small_box(), MPI_COMM_WORLD), fresh(small_box(), MPI_COMM_WORLD);
  std::vector<SphereState> all = spheres_everywhere();
  flow.boundary.set_spheres(all);
  EXPECT_EQ(flow.boundary.placings(), 1);
  all[4].velocity = {0.1, 0.2,
                     -0.3};  // what turns or is about to move has its markers where they were
  all[5].angular_velocity = {1.0, 0.0, 2.0};
  flow.boundary.move_spheres(all, flow.settings.time.step);
  EXPECT_EQ(flow.boundary.placings(), 1);
  fresh.boundary.set_spheres(all);
  std::vector<std::vector<SphereLoad>> loads;
  for (Flow<double>* f : {&flow, &fresh}) {
    f->fill(wavy);
    f->boundary.start_stage(f->velocity);
    f->boundary.force(f->velocity, 0.01, 0.01);
    loads.push_back(f->loads(0.01));
  }
  ASSERT_EQ(loads[0].size(), loads[1].size());
  for (std::size_t n = 0; n < loads[0].size(); ++n) {
    EXPECT_EQ(loads[0][n].force, loads[1][n].force);
    EXPECT_EQ(loads[0][n].torque, loads[1][n].torque);
  }
  // One sphere that moves, however little, or goes, and every rank finds markers again.
  all[5].position.x() = std::nextafter(all[5].position.x(), 1.0);
  flow.boundary.move_spheres(all, flow.settings.time.step);
  EXPECT_EQ(flow.boundary.placings(), 2);
  all.pop_back();
  flow.boundary.move_spheres(all, flow.settings.time.step);
  EXPECT_EQ(flow.boundary.placings(), 3);
}

TEST(Forcing, MarkersKeepTheirVolumesThroughAStep) {
  // Two spheres whose markers are in reach of each other part by three cells in one go. Within the
  // step each marker still weighs as little as beside the other sphere's; the next step weighs
  // anew.
  const auto force = [](Flow<double>& flow) {
    flow.fill([](int, const Vec3&) { return 1.0; });
    flow.boundary.start_stage(flow.velocity);
    return flow.force(0.01, true, 0.0).force_on_fluid.norm();
  };
  const Settings settings = small_box();
  const double h = make_grid(settings).h;
  const Vec3 apart(0.0, 0.0, 3.0 * h);
  std::vector<SphereState> all{sphere(1, {1.2, 1.0, 0.6}, true), sphere(2, {1.2, 1.0, 1.1}, true)};
  std::vector<SphereState> parted = all;
  parted[1].position += apart;
  Flow<double> flow(settings, MPI_COMM_WORLD), fresh(settings, MPI_COMM_WORLD);
  fresh.boundary.set_spheres(parted);
  const double weighed = force(fresh);
  flow.boundary.set_spheres(all);
  flow.boundary.move_spheres(parted, flow.settings.time.step, false);
  EXPECT_EQ(flow.boundary.weighings(), 1);
  EXPECT_LT(1.05 * force(flow), weighed);
  flow.boundary.move_spheres(parted, flow.settings.time.step,
                             true);  // nothing has moved, but the step is a new one
  EXPECT_EQ(flow.boundary.weighings(), 2);
  EXPECT_DOUBLE_EQ(force(flow), weighed);
  flow.boundary.move_spheres(parted, flow.settings.time.step, true);
  EXPECT_EQ(flow.boundary.weighings(), 2);
}

/// A sphere that a script lets grow, or inserts, between two stages has the volumes of a step's
/// begin: nobody knows others for its markers.
TEST(Forcing, WhatComesOrGrowsWithinAStepIsWeighedThere) {
  const auto force = [](Flow<double>& flow) {
    flow.fill([](int, const Vec3&) { return 1.0; });
    flow.boundary.start_stage(flow.velocity);
    return flow.force(0.01, true, 0.0).force_on_fluid;
  };
  const Settings settings = small_box();
  const std::vector<SphereState> all{sphere(1, {1.2, 1.0, 0.6}, true, 0.25),
                                     sphere(2, {1.2, 1.0, 1.12}, true, 0.25)};
  std::vector<SphereState> grown = all, another = all;
  grown[1].radius = 0.26;
  another[1].is_new = true;
  another[1].position.x() += 0.1;
  for (const auto& changed : {grown, another}) {
    Flow<double> flow(settings, MPI_COMM_WORLD), fresh(settings, MPI_COMM_WORLD);
    fresh.boundary.set_spheres(changed);
    flow.boundary.set_spheres(all);
    flow.boundary.move_spheres(changed, settings.time.step, false);
    EXPECT_EQ(flow.boundary.weighings(), 2);
    EXPECT_LT((force(flow) - force(fresh)).norm(), 1e-13 * force(fresh).norm());
  }
}

/// Layouts of sizes that no sphere has any more make room for others, and those in use stay.
TEST(Forcing, SpheresThatGrowKeepTheirMarkers) {
  const Settings settings = small_box();
  std::vector<SphereState> all{sphere(1, {0.6, 1.0, 0.6}, false, 0.31),
                               sphere(2, {1.6, 1.0, 1.1}, true, 0.25)};
  Flow<double> flow(settings, MPI_COMM_WORLD);
  flow.boundary.set_spheres(all);
  for (int n = 0; n < 200; ++n) {
    all[1].radius += 2e-4;
    flow.boundary.move_spheres({&all[1], 1}, settings.time.step, n % 3 == 0);
  }
  EXPECT_LE(flow.boundary.layouts(), 66u);  // of 201 sizes
  Flow<double> fresh(settings, MPI_COMM_WORLD);
  fresh.boundary.set_spheres(all);
  std::vector<Vec3> forces;
  for (Flow<double>* each : {&flow, &fresh}) {
    each->fill(wavy);
    each->boundary.start_stage(each->velocity);
    forces.push_back(each->force(0.01, true, 0.0).force_on_fluid);
  }
  EXPECT_LT((forces[0] - forces[1]).norm(), 1e-13 * forces[1].norm());
}

TEST(Forcing, OneLoopRemovesAlmostAllOfAnEvenSlip) {
  // The row sums make a slip that is even over the kernel's width vanish but for what curvature and
  // the neighbours' unevenness leave; a volume of one cell per marker would leave half of it, none
  // all of it, and twice the volume would leave as much with the sign turned.
  Flow<double> flow(small_box(), MPI_COMM_WORLD);
  flow.fill([](int c, const Vec3&) { return c == 0 ? 1.0 : 0.0; });
  flow.boundary.set_spheres(std::vector<SphereState>{sphere(1, {1.23, 1.04, 0.81}, false)});
  const ForcingReport report = flow.force(0.01, true);
  EXPECT_NEAR(report.before.max, 1.0, 1e-12);
  EXPECT_NEAR(report.before.rms, 1.0, 1e-12);
  EXPECT_LT(report.after.rms, 0.06);
  EXPECT_LT(report.after.max, 0.2);
}

TEST(Forcing, LoopsStopAtTheirNumberOrTheTolerance) {
  Settings settings = small_box();
  settings.spheres.forcing_loops = 12;
  Flow<double> all_loops(settings, MPI_COMM_WORLD);
  settings.spheres.slip_tolerance = 0.05;
  Flow<double> tolerant(settings, MPI_COMM_WORLD);
  for (Flow<double>* flow : {&all_loops, &tolerant}) {
    flow->fill(wavy);
    flow->boundary.set_spheres(std::vector<SphereState>{sphere(1, {1.23, 1.04, 0.81}, false)});
  }
  EXPECT_EQ(all_loops.force(0.01).loops, 12);
  const ForcingReport report = tolerant.force(0.01);
  EXPECT_LT(report.loops, 12);
  EXPECT_GT(report.loops, 1);
  EXPECT_LE(report.after.max, 0.05);
  EXPECT_NEAR(tolerant.boundary.slip(tolerant.velocity).max, report.after.max, 1e-12);
}

TEST(Forcing, LoopsDoNotWaitForMarkersThatStandBack) {
  // Beside another sphere some markers keep a few hundredths of their volume: no loop takes their
  // slip, and the tolerance is met without.
  Settings settings = small_box();
  settings.spheres.forcing_loops = 12;
  settings.spheres.slip_tolerance = 0.15;
  Flow<double> flow(settings, MPI_COMM_WORLD);
  flow.fill(wavy);
  const double gap = 0.5 * flow.grid.h;
  flow.boundary.set_spheres(std::vector<SphereState>{
      sphere(1, {1.23, 1.04, 0.81}, true), sphere(2, {1.23, 1.04 + 0.8 + gap, 0.81}, true)});
  flow.boundary.start_stage(flow.velocity);
  const ForcingReport report = flow.force(0.01);
  EXPECT_LT(report.loops, 12);
  EXPECT_GT(report.loops, 3);  // those that can be taken are waited for
  EXPECT_GT(report.after.max, 1.0);
}

/// Force of one loop on fluid that goes at 1 through a face-centred cubic packing of volume
/// fraction 0.6, six cells to a diameter, gaps of 0.4 cells. The step is that of
/// `diffusion_number`, time.step `longer` times as long.
double force_of_packing(bool mobile, double diffusion_number, double longer = 1.0) {
  Settings settings;
  const double length = std::cbrt(4.0 * std::numbers::pi / 6.0 / 0.6), h = length / 9.0;
  settings.grid.cells = {9, 9, 9};
  settings.grid.length = {length, length, length};
  settings.boundary.y = {Wall::periodic, Wall::periodic};
  settings.fluid.kinematic_viscosity = 1.0;
  settings.time.step = longer * diffusion_number * h * h;
  settings.spheres.forcing_loops = 1;
  Flow<double> flow(settings, MPI_COMM_SELF);
  flow.fill([](int c, const Vec3&) { return c == 0 ? 1.0 : 0.0; });
  std::vector<SphereState> all;
  all.reserve(4);
  for (int n = 0; n < 4; ++n)
    all.push_back(sphere(n,
                         length * Vec3(n == 1 || n == 2, n == 1 || n == 3, n == 2 || n == 3) / 2 +
                             Vec3(0.26, 0.27, 0.24) * length,
                         mobile, 0.5));
  for (SphereState& s : all) s.position = inside_the_box(flow.grid, s.position);
  flow.boundary.set_spheres(all);
  if (mobile) flow.boundary.move_spheres(all, settings.time.step / longer);
  flow.boundary.start_stage(flow.velocity);
  return flow.force(0.01).force_on_fluid.x();
}

TEST(Forcing, PackingsOfMobileSpheresHoldWhatFlowsThroughThem) {
  // Nearly all markers stand beside two others: without pores six tenths of the force are missing.
  const double fixed = force_of_packing(false, 0.2);
  EXPECT_NEAR(force_of_packing(true, 0.2) / fixed, 1.0, 0.01);
  EXPECT_NEAR(force_of_packing(true, 7.2) / fixed, 1.0, 0.01);
  // With shorter steps, or more loops, each takes a part of it.
  EXPECT_LT(force_of_packing(true, 0.05) / fixed, 0.8);
  EXPECT_GT(force_of_packing(true, 0.05) / fixed, 0.5);
  // It is the step that is made that counts, which is shorter than time.step with time.cfl.
  EXPECT_DOUBLE_EQ(force_of_packing(true, 0.05, 4.0), force_of_packing(true, 0.05));
  EXPECT_DOUBLE_EQ(share_at_pores(0.05, 1), 0.5);
  EXPECT_DOUBLE_EQ(share_at_pores(0.2, 4), 0.5);
  EXPECT_EQ(share_at_pores(7.2, 3), 1.0);
}

/// Force of one loop on fluid that goes at 1 along x past a mobile sphere and two neighbours, each
/// 0.3 cells from the two others, the first of which is mobile or fixed.
double force_of_three(bool mobile, double diffusion_number) {
  Settings settings = small_box();
  settings.fluid.kinematic_viscosity = 1.0;
  settings.time.step = diffusion_number * 0.01;  // cells of 0.1
  Flow<double> flow(settings, MPI_COMM_SELF);
  flow.fill([](int c, const Vec3&) { return c == 0 ? 1.0 : 0.0; });
  const double side = 0.63, height = side * std::sqrt(0.75);
  flow.boundary.set_spheres(
      std::vector<SphereState>{sphere(1, {1.2, 0.6, 0.8}, true, 0.3),
                               sphere(2, {1.2 - side / 2, 0.6 + height, 0.8}, mobile, 0.3),
                               sphere(3, {1.2 + side / 2, 0.6 + height, 0.8}, false, 0.3)});
  flow.boundary.start_stage(flow.velocity);
  return flow.force(0.01).force_on_fluid.x();
}

TEST(Forcing, APoreHasAMobileSphereBesideTheMarkersOwn) {
  // Between two fixed ones the gap under a grain is left to films, whatever the step.
  EXPECT_DOUBLE_EQ(force_of_three(false, 0.2), force_of_three(false, 1e-4));
  EXPECT_GT(force_of_three(true, 0.2) / force_of_three(true, 1e-4), 1.03);
}

TEST(Forcing, FilmsAndPores) {
  EXPECT_EQ(volume_beside(0.9, 4.1, 1.0), 0.0);  // a film
  EXPECT_EQ(volume_beside(2.1, 2.1, 0.0), 1.0);  // nothing near
  EXPECT_NEAR(volume_beside(1.4, 4.1, 1.0), 0.4, 1e-12);
  EXPECT_NEAR(volume_beside(0.9, 2.9, 0.3), 0.3, 1e-12);  // a pore
  EXPECT_NEAR(volume_beside(0.9, 3.5, 1.0), 0.5, 1e-12);
  EXPECT_NEAR(volume_beside(1.4, 2.9, 0.5), 0.7, 1e-12);
}

/// Root mean square slip of eight spheres about one point, overlapping, before each of twenty loops
/// and behind the last: supports are shared up to eight times.
std::vector<double> slips_of_eight(bool mobile) {
  Settings settings = small_box();
  settings.spheres.forcing_loops = 1;
  Flow<double> flow(settings, MPI_COMM_WORLD);
  flow.fill(wavy);
  std::vector<SphereState> all;
  all.reserve(8);
  for (int n = 0; n < 8; ++n)
    all.push_back(
        sphere(n, Vec3(1.2, 1.0, 0.8) + 0.22 * Vec3(n & 1 ? 1 : -1, n & 2 ? 1 : -1, n & 4 ? 1 : -1),
               mobile && n != 3));
  flow.boundary.set_spheres(all);
  std::vector<double> slips;
  for (int loop = 0; loop < 20; ++loop) {
    flow.boundary.start_stage(flow.velocity);
    const ForcingReport report = flow.force(0.01, true);
    if (loop == 0) slips.push_back(report.before.rms);
    slips.push_back(report.after.rms);
  }
  return slips;
}

TEST(Forcing, SpheresInContactStayStable) {
  // With one cell's volume for each marker twenty loops would blow up; with row sums no loop raises
  // the slip.
  for (const bool mobile : {false, true}) {
    const std::vector<double> slips = slips_of_eight(mobile);
    for (std::size_t n = 1; n < slips.size(); ++n) EXPECT_LT(slips[n], slips[n - 1]) << n;
    // Mobile ones leave the fluid between them alone; where they begin to, part of the slip stays.
    EXPECT_LT(slips.back(), mobile ? 0.5 * slips.front() : 0.1);
  }
}

/// Every rank also computes the whole box alone; both must agree to round-off, ghosts included.
void compare_with_one_rank(Settings settings, int z_parts) {
  settings.spheres.forcing_loops = 3;
  Flow<double> shared(settings, MPI_COMM_WORLD, z_parts), alone(settings, MPI_COMM_SELF);
  std::vector<SphereState> all = spheres_everywhere();
  for (int move = 0; move < 6; ++move) {
    if (move == 3) all[0] = sphere(99, all[0].position + Vec3(0.4, 0.0, 0.3), true, 0.3);
    const double dt = 0.01;
    std::vector<std::vector<SphereLoad>> loads;
    std::vector<ForcingReport> reports;
    for (Flow<double>* flow : {&shared, &alone}) {
      flow->fill(wavy);
      if (move == 0) flow->boundary.set_spheres(all);
      // Two steps of three stages: in those that do not weigh, markers come from another rank.
      if (move > 0) flow->boundary.move_spheres(all, settings.time.step, move % 3 == 0);
      flow->boundary.start_stage(flow->velocity);
      reports.push_back(flow->force(dt, true, move % 3 == 0 ? dt : 0.0));
      EXPECT_EQ(flow->boundary.weighings(), 1 + move / 3);
      loads.push_back(flow->loads(dt));
    }
    double worst = 0.0;
    const bool lower = shared.decomposition.at_lower_wall(),
               upper = shared.decomposition.at_upper_wall();
    for (int j = lower ? 0 : -1; j < shared.decomposition.planes() + (upper ? 0 : 1); ++j)
      for (int k = -1; k <= shared.decomposition.rows(); ++k)
        for (int c = 0; c < 3; ++c)
          for (int i = -1; i <= shared.grid.cells[0]; ++i)
            worst = std::max(
                worst, std::abs(shared.velocity.row(j, k, c)[i] -
                                alone.velocity.row(shared.decomposition.first() + j,
                                                   shared.decomposition.first_row() + k, c)[i]));
    EXPECT_LT(worst, 1e-13) << "sums of order 1 in another order";
    ASSERT_EQ(loads[0].size(), 4u);
    for (std::size_t n = 0; n < 4; ++n) {
      EXPECT_EQ(loads[0][n].tag, loads[1][n].tag);
      EXPECT_LT((loads[0][n].force - loads[1][n].force).norm(), 1e-10 * loads[1][n].force.norm());
      EXPECT_LT((loads[0][n].torque - loads[1][n].torque).norm(),
                1e-10 * (1e-3 + loads[1][n].torque.norm()));
    }
    EXPECT_NEAR(reports[0].after.rms, reports[1].after.rms, 1e-13);
    EXPECT_NEAR(reports[0].after.max, reports[1].after.max, 1e-13);
    EXPECT_LT((reports[0].force_of_fixed - reports[1].force_of_fixed).norm(),
              1e-11 * reports[1].force_of_fixed.norm());
    // Up through an interface between slabs, within a step not as far as a rank sees.
    all[0].position += (move % 3 == 2 ? 1.0 : 0.3) * Vec3(0.021, 0.33, -0.07);
    all[4].position += Vec3(0.013, 0.051, 0.033);
  }
}

TEST(Forcing, DoesNotKnowTheRanks) {
  for (const int z_parts : splits(size_of(MPI_COMM_WORLD)))
    compare_with_one_rank(small_box(), z_parts);
}

TEST(Forcing, DoesNotKnowTheRanksWherePeriodicYCloses) {
  Settings settings = small_box();
  settings.boundary.y = {Wall::periodic, Wall::periodic};
  for (const int z_parts : splits(size_of(MPI_COMM_WORLD)))
    compare_with_one_rank(settings, z_parts);
}

TEST(Forcing, SeamsAreInvisible) {
  // A sphere across both seams does to the shifted flow what one in the middle does.
  Flow<double> middle(small_box(), MPI_COMM_WORLD), seam(small_box(), MPI_COMM_WORLD);
  const int shift_x = 12, shift_z = 8;
  const Vec3 shift(1.2, 0.0, 0.8);
  middle.fill(wavy);
  seam.fill([&](int c, const Vec3& x) { return wavy(c, x + shift); });
  middle.boundary.set_spheres(std::vector<SphereState>{sphere(1, {1.23, 1.0, 0.78}, true)});
  seam.boundary.set_spheres(std::vector<SphereState>{sphere(1, {0.03, 1.0, 1.58}, true)});
  std::vector<SphereLoad> loads;
  for (Flow<double>* flow : {&middle, &seam}) {
    flow->boundary.start_stage(flow->velocity);
    flow->boundary.force(flow->velocity, 0.01, 0.01);
    loads.push_back(flow->loads(0.01).at(0));
  }
  double worst = 0.0;
  for (int j = 0; j < seam.decomposition.planes(); ++j)
    for (int k = 0; k < 16; ++k)
      for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 24; ++i)
          worst = std::max(
              worst, std::abs(seam.velocity.row(j, k, c)[i] -
                              middle.velocity.row(j, (k + shift_z) % 16, c)[(i + shift_x) % 24]));
  EXPECT_LT(worst, 1e-12);
  EXPECT_LT((loads[0].force - loads[1].force).norm(), 1e-9 * loads[0].force.norm());
  EXPECT_LT((loads[0].torque - loads[1].torque).norm(), 1e-9 * loads[0].force.norm());
}

/// A mobile sphere that lies between two images of a fixed one, in a box that is little wider than
/// they are, beside the same scene with twice the width: markers weigh the same, to round-off. With
/// the nearest image alone the slip that is left differs by 1 per cent.
TEST(Forcing, ANarrowBoxIsItselfDoubled) {
  const auto flow = [](double z, double x, double y, int c) {
    const double a = 2.0 * std::numbers::pi * x / 2.4, b = 2.0 * std::numbers::pi * z;
    return 1.0 + 0.3 * c + 0.5 * std::sin(a + c) * std::cos(2.0 * y) + 0.2 * std::cos(b - c);
  };
  struct Result {
    Vec3 load;
    double slip_max, slip_rms;
  };
  const auto result = [&](int copies) {
    Settings s = small_box();
    s.grid.cells[2] = 10 * copies;
    s.grid.length[2] = copies;
    std::vector<SphereState> all;
    for (int n = 0; n < copies; ++n) {
      all.push_back(sphere(1 + n, {1.2, 1.31, 0.02 + n}, true));
      all.push_back(sphere(11 + n, {1.25, 0.7, 0.5 + n}, false));
    }
    Flow<double> narrow(s, MPI_COMM_SELF);
    narrow.boundary.set_spheres(all);
    narrow.fill([&](int c, const Vec3& x) { return flow(x.z(), x.x(), x.y(), c); });
    narrow.boundary.start_stage(narrow.velocity);
    const ForcingReport report = narrow.force(0.01, true);
    return Result{narrow.loads(0.01)[0].force, report.after.max, report.after.rms};
  };
  const Result once = result(1), twice = result(2);
  EXPECT_LT((once.load - twice.load).norm(), 1e-10 * twice.load.norm());
  EXPECT_NEAR(once.slip_max, twice.slip_max, 1e-10);
  EXPECT_NEAR(once.slip_rms, twice.slip_rms, 1e-10);
}

TEST(Forcing, SinglePrecisionAgreesWithDouble) {
  Flow<float> single(small_box(), MPI_COMM_WORLD);
  Flow<double> twice(small_box(), MPI_COMM_WORLD);
  single.fill(wavy);
  twice.fill(wavy);
  single.boundary.set_spheres(spheres_everywhere());
  twice.boundary.set_spheres(spheres_everywhere());
  single.boundary.start_stage(single.velocity);
  twice.boundary.start_stage(twice.velocity);
  const Vec3 a = single.force(0.01).force_on_fluid;
  const Vec3 b = twice.force(0.01).force_on_fluid;
  EXPECT_LT((a - b).norm(), 1e-5 * b.norm());
  EXPECT_GT((a - b).norm(), 1e-12 * b.norm()) << "both were computed in double";
}

TEST(Forcing, MistakesAreNamed) {
  Flow<double> flow(small_box(), MPI_COMM_WORLD);
  const std::vector<SphereState> twins{sphere(3, {1, 1, 1}, true), sphere(3, {0.5, 1, 1}, false)};
  EXPECT_THROW(flow.boundary.set_spheres(twins), UserError);
  EXPECT_THROW(flow.boundary.set_spheres(std::vector<SphereState>{sphere(3, {1, 1, 1}, true, 0.0)}),
               UserError);
  flow.boundary.set_spheres(std::vector<SphereState>{sphere(3, {1, 1, 1}, false)});
  const std::vector<SphereState> moving{sphere(4, {1, 1, 1}, true), sphere(4, {0.5, 1, 1}, true)};
  EXPECT_THROW(flow.boundary.move_spheres(moving, flow.settings.time.step), UserError);
}

}  // namespace
}  // namespace bedload
