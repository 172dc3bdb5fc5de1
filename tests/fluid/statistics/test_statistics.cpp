#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "fluid/settings/errors.hpp"
#include "fluid/statistics/sphere_layer.hpp"
#include "fluid/statistics/statistics.hpp"
#include "tests/fluid/carry_over.hpp"
#include "tests/fluid/flow_case.hpp"
#include "tests/fluid/output_helpers.hpp"

namespace bedload {
namespace {

/// A flow that is written down instead of computed, and the statistics of it.
struct WrittenFlow {
  WrittenFlow(const Settings& s, MPI_Comm comm)
      : settings(s),
        grid(make_grid(settings)),
        decomposition(grid, comm, blocks(grid, comm)),
        fields(grid, decomposition.extent()),
        statistics(settings, grid, decomposition) {}

  /// Even blocks, two side by side along z where the number of ranks allows.
  static Cuts blocks(const Grid& grid, MPI_Comm comm) {
    int ranks = 1;
    MPI_Comm_size(comm, &ranks);
    return even_cuts(grid, ranks, ranks % 2 == 0 ? 2 : 1);
  }
  /// value(component, place), 3: pressure; beyond walls, which are at rest, everything is odd.
  void write(const std::function<double(int, const Vec3&)>& value) {
    for (int j = 0; j < decomposition.planes(); ++j) {
      for (int k = 0; k < decomposition.rows(); ++k)
        for (int c = 0; c < 4; ++c)
          for (int i = 0; i < grid.cells[0]; ++i) {
            Vec3 place(grid.centre(i), grid.centre(decomposition.first() + j),
                       grid.centre(decomposition.first_row() + k));
            if (c < 3) place[c] += 0.5 * grid.h;
            (c < 3 ? velocity.row(j, k, c) : pressure.row(j, k))[i] = value(c, place);
          }
      wrap_x_ghosts(velocity, j);
    }
    decomposition.exchange(velocity);
    const auto mirror = [&](int ghost, int inner) {
      for (std::size_t n = 0; n < velocity.plane_size(); ++n)
        velocity.plane(ghost)[n] = -velocity.plane(inner)[n];
    };
    if (decomposition.at_lower_wall()) mirror(-1, 0);
    if (decomposition.at_upper_wall()) mirror(decomposition.planes(), decomposition.planes() - 1);
  }
  void sample(std::span<const SphereState> spheres = {}, double duration = 1.0) {
    statistics.sample({grid, decomposition, fields, time, step, driving}, spheres, duration);
    time += 1.0;
    ++step;
  }

  Settings settings;
  Grid grid;
  Decomposition decomposition;
  FlowFields<double> fields;
  Field<double>&velocity = fields[Stored::velocity], &pressure = fields[Stored::pressure];
  Statistics<double> statistics;
  double time = 0.0, driving = 0.25;
  std::int64_t step = 0;
};

Settings periodic_box() {
  Settings s = box({16, 12, 20}, 0.125, 0.01, 0.01);
  set_y_ends(s, Wall::periodic, Wall::periodic);
  s.statistics.every = 1;
  return s;
}

/// Two spheres, one through the periodic end of y and fixed: volumes by hand, and the velocity of a
/// turning sphere's layers, u - omega_z s at the height s over its centre.
TEST(Statistics, ProfilesOfGrainsAreExactOnAnyRanks) {
  WrittenFlow flow(periodic_box(), MPI_COMM_WORLD);
  const double h = flow.grid.h, area = flow.grid.length[0] * flow.grid.length[2], radius = 0.3;
  flow.write([](int, const Vec3&) { return 0.0; });
  SphereState moving{.tag = 1, .position = {0.4, 6 * h, 0.5}, .radius = radius};
  moving.velocity = {2.0, 0.5, -1.0};
  moving.angular_velocity = {3.0, 7.0, 4.0};
  const SphereState fixed{.tag = 2, .position = {1.0, 0.0, 1.5}, .radius = 0.2, .mobile = false};
  flow.sample(std::vector{moving, fixed}, 2.0);
  flow.sample({}, 2.0);  // half of the time there is nothing
  const FlowStatistics s = flow.statistics.result();
  double grains = 0.0, mobile = 0.0, flux = 0.0, across = 0.0;
  for (std::size_t j = 0; j < s.y.size(); ++j) {
    grains += s.grains[j] * h * area;
    mobile += s.mobile[j] * h * area;
    flux += s.mobile[j] * s.grain_u[j] * h * area;
    across += s.mobile[j] * s.grain_v[j] * h * area;
    const double from = s.y_face[j] - 6 * h, to = from + h;  // over the moving sphere's centre
    if (s.mobile[j] == 0.0) {
      EXPECT_EQ(s.grain_u[j], 0.0);
      continue;
    }
    EXPECT_DOUBLE_EQ(s.grain_spin[j], 4.0);
    if (std::max(std::abs(from), std::abs(to)) > radius) continue;
    // pi (R^2 s - s^3/3) and its first moment pi (R^2 s^2/2 - s^4/4)
    const double volume = M_PI * (radius * radius * h - (to * to * to - from * from * from) / 3.0);
    const double moment = M_PI * (radius * radius * (to * to - from * from) / 2.0 -
                                  (std::pow(to, 4) - std::pow(from, 4)) / 4.0);
    EXPECT_NEAR(s.mobile[j], 0.5 * volume / (h * area), 1e-14);
    EXPECT_NEAR(s.grain_u[j], 2.0 - 4.0 * moment / volume, 1e-12);
    EXPECT_NEAR(s.grain_v[j], 0.5, 1e-12);
    EXPECT_NEAR(s.grain_w[j], -1.0 + 3.0 * moment / volume, 1e-12);
  }
  const double sphere = 4.0 / 3.0 * M_PI * radius * radius * radius;
  EXPECT_NEAR(mobile, 0.5 * sphere, 1e-14);
  EXPECT_NEAR(grains, 0.5 * (sphere + 4.0 / 3.0 * M_PI * 0.008), 1e-14);
  EXPECT_NEAR(flux, 0.5 * sphere * 2.0, 1e-13);
  EXPECT_NEAR(across, 0.5 * sphere * 0.5, 1e-13);
}

/// A sphere that touches a plane of cell faces is not beyond it: the cap that round-off leaves
/// there has no volume, whose sign would be any and whose mean velocity noise.
TEST(Statistics, NothingOfASphereIsBeyondThePlaneThatItTouches) {
  const double h = 0.1, radius = 0.3;
  for (int j = 0; j < 200; ++j) {
    const double y = (j + 3) * h, below = j * h, above = (j + 6) * h;
    EXPECT_EQ(sphere_layer(radius, above - y, above + h - y).volume, 0.0) << j;
    EXPECT_EQ(sphere_layer(radius, below - h - y, below - y).volume, 0.0) << j;
    EXPECT_GT(sphere_layer(radius, above - h - y, above - y).volume, 0.0) << j;
  }
}

/// Waves whose averages are known: each covariance of two components comes from one wave that both
/// hold; a product on an edge sees each of them through the mean of two points, cos(k h/2).
TEST(Statistics, CovariancesOfWavesAreExact) {
  WrittenFlow flow(periodic_box(), MPI_COMM_WORLD);
  const double h = flow.grid.h, kx = 2 * M_PI / flow.grid.length[0],
               kz = 2 * M_PI / flow.grid.length[2];
  const double phase = 0.3;
  flow.write([&](int c, const Vec3& x) {
    const double along_x = std::cos(kx * x[0]), along_z = std::cos(kz * x[2]);
    if (c == 0) return 2.0 + x[1] + 0.5 * along_z;
    if (c == 1) return 0.1 + 0.4 * std::cos(kz * x[2] + phase) + 0.3 * along_x;
    if (c == 2) return -1.0 + 0.2 * along_x + 0.6 * std::cos(3 * kz * x[2]);
    return 7.0 + 0.8 * along_z;
  });
  flow.sample();
  const FlowStatistics s = flow.statistics.result();
  // u and v share the wave along z, both seen at k; v and w the wave along x, both seen at i.
  const double tolerance = 1e-13;
  for (std::size_t j = 0; j < s.y.size(); ++j) {
    EXPECT_NEAR(s.u[j], 2.0 + s.y[j], tolerance);
    EXPECT_NEAR(s.w[j], -1.0, tolerance);
    EXPECT_NEAR(s.p[j], 7.0, tolerance);
    EXPECT_NEAR(s.uu[j], 0.5 * 0.25, tolerance);
    EXPECT_NEAR(s.ww[j], 0.5 * (0.04 + 0.36), tolerance);
    EXPECT_NEAR(s.pp[j], 0.5 * 0.64, tolerance);
    EXPECT_NEAR(s.uw[j], 0.0, tolerance);
    EXPECT_EQ(s.fluid[j], 1.0);
  }
  for (std::size_t f = 0; f < s.y_face.size(); ++f) {
    EXPECT_NEAR(s.v[f], 0.1, tolerance);
    EXPECT_NEAR(s.vv[f], 0.5 * (0.16 + 0.09), tolerance);
    if (f == 0 || f + 1 == s.y_face.size()) continue;  // x + y jumps at the periodic end
    EXPECT_NEAR(s.uv[f], 0.5 * 0.5 * 0.4 * std::cos(phase), tolerance);
    EXPECT_NEAR(s.vw[f], 0.5 * 0.3 * 0.2, tolerance);
    // Fluxes of the whole: mu du/dy, -rho <u v> with the means in it.
    EXPECT_NEAR(s.viscous[f], 0.01, tolerance);
    EXPECT_NEAR(s.turbulent[f], -(s.uv[f] + 0.1 * (2.0 + s.y_face[f])), tolerance);
  }
  // An oblique wave with u = -w, both seen through means of two.
  flow.write([&](int c, const Vec3& x) {
    return (c == 0 ? 1.0 : c == 2 ? -1.0 : 0.0) * std::cos(kx * x[0] + kz * x[2]);
  });
  WrittenFlow oblique(periodic_box(), MPI_COMM_WORLD);
  oblique.velocity = std::move(flow.velocity);
  oblique.sample();
  for (const double uw : oblique.statistics.result().uw)
    EXPECT_NEAR(uw, -0.5 * std::cos(0.5 * kx * h) * std::cos(0.5 * kz * h), tolerance);
}

/// Through the seam of periodic y, too, a stream that carries nothing but its mean has no
/// covariance.
TEST(Statistics, TheSeamOfPeriodicYIsAFaceLikeOthers) {
  WrittenFlow flow(periodic_box(), MPI_COMM_WORLD);
  const double ky = 2 * M_PI / flow.grid.length[1];
  flow.write([&](int c, const Vec3& x) {
    return c == 0 ? std::sin(ky * x[1] + 0.5) : c == 1 ? 0.2 : std::cos(ky * x[1]);
  });
  flow.sample();
  const FlowStatistics s = flow.statistics.result();
  EXPECT_GT(std::abs(s.u.front() - s.u.back()), 0.1);
  for (std::size_t f = 0; f < s.y_face.size(); ++f) {
    EXPECT_NEAR(s.uv[f], 0.0, 1e-14) << f;
    EXPECT_NEAR(s.vw[f], 0.0, 1e-14) << f;
  }
}

/// Where something else than y walls holds the flow the stress is no straight line between them.
TEST(Statistics, StressIsComparedWithALineBetweenYWallsAlone) {
  const auto has_line = [](const Ends& ends, double fringe_rate) {
    Settings s = periodic_box();
    set_ends(s, ends);
    s.fringe.rate = fringe_rate;
    WrittenFlow flow(s, MPI_COMM_WORLD);
    flow.write([](int c, const Vec3& x) { return c == 0 ? x[1] * (1.5 - x[1]) : 0.0; });
    flow.sample();
    return flow.statistics.result().stress_defect.has_value();
  };
  EXPECT_TRUE(has_line({periodic, no_slip, periodic}, 0.0));
  EXPECT_TRUE(has_line({periodic, open_channel, free_slip}, 0.0));
  EXPECT_FALSE(has_line({periodic, periodic, periodic}, 0.0));
  EXPECT_FALSE(has_line({periodic, no_slip, open_channel}, 0.0));
  EXPECT_FALSE(has_line({free_slip, no_slip, periodic}, 0.0));
  EXPECT_FALSE(has_line({periodic, no_slip, periodic}, 2.0));
}

/// Samples count by the time that they stand for.
TEST(Statistics, SamplesAreWeightedByTheirTime) {
  WrittenFlow flow(periodic_box(), MPI_COMM_WORLD);
  for (const auto& [value, duration] : {std::pair{1.0, 3.0}, {5.0, 1.0}}) {
    flow.write([v = value](int c, const Vec3&) { return c == 0 ? v : 0.0; });
    flow.sample({}, duration);
  }
  const FlowStatistics s = flow.statistics.result();
  EXPECT_EQ(s.samples, 2);
  EXPECT_EQ(s.end - s.begin, 1.0);
  EXPECT_NEAR(s.u[3], 2.0, 1e-14);
  EXPECT_NEAR(s.uu[3], 3.0, 1e-14);            // (3 * 1 + 25)/4 - 4
  EXPECT_NEAR(s.acceleration[3], 4.0, 1e-13);  // from 1 to 5 within 1
}

/// Where steps differ in length a sample stands for all of them since the one before.
TEST(Statistics, ASampleStandsForTheTimeSinceTheOneBefore) {
  WrittenFlow flow(periodic_box(), MPI_COMM_WORLD);
  flow.write([](int, const Vec3&) { return 1.0; });
  EXPECT_EQ(flow.statistics.duration_at(7.0, 0.3), 0.3);
  flow.sample({}, 0.3);
  const double last = flow.statistics.result().end;
  EXPECT_EQ(flow.statistics.duration_at(last + 0.75, 0.3), 0.75);
}

/// A parabola between two walls: the stress is the straight line from one wall to the other, and
/// nothing is left that spheres would have to do.
TEST(Statistics, PoiseuilleFlowHasItsStress) {
  const double gradient = 0.25, height = 1.5, viscosity = 0.01;
  Settings s = box({16, 12, 20}, 0.125, viscosity, 0.01);
  set_y_ends(s, Wall::no_slip, Wall::no_slip);
  s.fluid.density = 2.0;
  s.reference.height = 0.5 * height;
  WrittenFlow flow(s, MPI_COMM_WORLD);
  // The discrete solution: the parabola at the centres, raised so that the mirrored ghost cancels.
  const double h = flow.grid.h, curvature = gradient / (2.0 * viscosity * 2.0);
  flow.write([&](int c, const Vec3& x) {
    return c == 0 ? curvature * (x[1] * (height - x[1]) + 0.25 * h * h) : 0.0;
  });
  for (int n = 1; n < 9; ++n) flow.sample({}, 0.1 / n);  // durations that do not add up exactly
  const FlowStatistics r = flow.statistics.result();
  for (const double share : r.fluid) EXPECT_EQ(share, 1.0);
  EXPECT_NEAR(r.wall_stress[0], 0.5 * gradient * height, 1e-13);
  EXPECT_NEAR(r.wall_stress[1], 0.5 * gradient * height, 1e-13);
  EXPECT_NEAR(r.u_tau.value(), std::sqrt(0.5 * gradient * height / 2.0), 1e-13);
  EXPECT_NEAR(r.re_tau.value(), *r.u_tau * 0.5 * height / viscosity, 1e-12);
  ASSERT_TRUE(r.stress_defect);
  EXPECT_LT(*r.stress_defect, 1e-12);
  EXPECT_NEAR(r.driving, gradient, 1e-15);
  for (std::size_t f = 0; f < r.y_face.size(); ++f)
    EXPECT_NEAR(r.viscous[f], gradient * (0.5 * height - r.y_face[f]), 1e-13);
  for (const double force : r.spheres) EXPECT_NEAR(force, 0.0, 1e-12);
}

/// u_tau of an open channel is that of its one wall: the free surface is none.
TEST(Statistics, TheFreeSurfaceBearsNoFriction) {
  Settings s = box({16, 12, 16}, 0.125, 0.01, 0.01);
  set_y_ends(s, Wall::no_slip, Wall::free_slip);
  s.fluid.density = 2.0;
  s.reference.height = 1.5;
  Channel<double> channel(s, MPI_COMM_WORLD);
  channel.set_velocity([](int c, const Vec3& x) { return c == 0 ? x[1] * (3.0 - x[1]) : 0.0; });
  Statistics<double> statistics(channel.settings(), channel.grid(), channel.decomposition());
  statistics.sample(view_of(std::as_const(channel)), {}, 1.0);
  const FlowStatistics r = statistics.result();
  EXPECT_GT(r.wall_stress[0], 0.05);
  EXPECT_NEAR(r.u_tau.value(), std::sqrt(r.wall_stress[0] / 2.0), 1e-13);
}

/// With spheres in a flow that walls drive u_tau is the walls': of the one that bears more, as a
/// bed shields the other. Where neither a wall nor a bed holds the flow there is none.
TEST(Statistics, FrictionWithoutADrivingForceIsTheWalls) {
  const double viscosity = 0.01, density = 2.0;
  const std::vector<SphereState> spheres{
      {.tag = 1, .position = {0.7, 0.4, 0.6}, .radius = 0.3, .mobile = false}};
  const auto result_of = [&](const std::array<Wall, 2>& ends, std::span<const SphereState> there) {
    Settings s = box({24, 20, 24}, 1.0 / 16, viscosity, 0.002);
    set_y_ends(s, ends[0], ends[1]);
    s.fluid.density = density;
    Channel<double> channel(s, MPI_COMM_WORLD);
    channel.set_velocity([](int c, const Vec3& x) { return c == 0 ? x[1] * x[1] : 0.0; });
    Statistics<double> statistics(channel.settings(), channel.grid(), channel.decomposition());
    statistics.sample(view_of(std::as_const(channel)), there, 1.0);
    return statistics.result();
  };
  const FlowStatistics held = result_of(no_slip, spheres);
  const double lower = std::abs(held.wall_stress[0]), upper = std::abs(held.wall_stress[1]);
  EXPECT_GT(upper, 2.0 * lower);
  EXPECT_NEAR(held.u_tau.value(), std::sqrt(upper / density), 1e-13);
  EXPECT_NEAR(result_of(no_slip, {}).u_tau.value(), std::sqrt(0.5 * (lower + upper) / density),
              1e-13);
  for (const auto& ends : {periodic, free_slip})
    for (const std::span<const SphereState> there : {std::span(spheres), {}}) {
      const FlowStatistics free = result_of(ends, there);
      EXPECT_FALSE(free.u_tau || free.re_tau);
    }
}

/// Of what drives a flow over a bed side walls take a part: u_tau is not the driving's then.
TEST(Statistics, SideWallsTakeAPartOfTheDriving) {
  const std::vector<SphereState> spheres{
      {.tag = 1, .position = {0.7, 0.4, 0.6}, .radius = 0.3, .mobile = false}};
  for (const Wall side : {Wall::free_slip, Wall::no_slip}) {
    Settings s = box({24, 20, 24}, 1.0 / 16, 0.01, 0.002);
    s.flow.driving = Driving::pressure_gradient;
    s.flow.pressure_gradient = 0.3;
    s.boundary.z = {side, side};
    Channel<double> channel(s, MPI_COMM_WORLD);
    channel.set_velocity([](int c, const Vec3& x) { return c == 0 ? x[1] : 0.0; });
    Statistics<double> statistics(channel.settings(), channel.grid(), channel.decomposition());
    statistics.sample(view_of(std::as_const(channel)), spheres, 1.0);
    EXPECT_EQ(statistics.result().u_tau.has_value(), side == Wall::free_slip);
  }
}

/// The stress defect is the largest distance of the stress from the line between both walls, over
/// the stress of the walls: here of a cubic profile, by hand from its values.
TEST(Statistics, TheStressDefectIsTheLargestDistanceFromTheLine) {
  const double height = 1.5, density = 2.0, viscosity = 0.01;
  Settings s = box({16, 12, 16}, 0.125, viscosity, 0.01);
  set_y_ends(s, Wall::no_slip, Wall::no_slip);
  s.fluid.density = density;
  WrittenFlow flow(s, MPI_COMM_WORLD);
  const auto u = [&](double y) { return y * (height - y) * (1.0 + y); };
  flow.write([&](int c, const Vec3& x) { return c == 0 ? u(x[1]) : 0.0; });
  flow.sample({}, 1.0);
  const FlowStatistics r = flow.statistics.result();
  const double h = flow.grid.h, mu = density * viscosity;
  const double lower = mu * 2.0 * u(0.5 * h) / h, upper = mu * 2.0 * u(height - 0.5 * h) / h;
  double largest = 0.0;
  for (int f = 1; f < 12; ++f) {
    const double stress = mu * (u((f + 0.5) * h) - u((f - 0.5) * h)) / h;
    largest = std::max(largest, std::abs(stress - lower + (lower + upper) * f / 12.0));
  }
  ASSERT_TRUE(r.stress_defect);
  EXPECT_GT(*r.stress_defect, 0.1);
  EXPECT_NEAR(*r.stress_defect, largest / (0.5 * (lower + upper)), 1e-12);
}

/// In a flow that computes itself, what driving, viscous and turbulent stress give a plane is what
/// it speeds up by: the scheme's own fluxes balance, whatever the flow looks like, on cubes and on
/// cells drawn to the wall.
void expect_balance(double stretching) {
  SCOPED_TRACE(stretching);
  Settings s = box({24, 16, 20}, 1.0 / 16, 1e-3, 0.002);
  s.grid.y_stretching = stretching;
  disturb(s, 1.0, 0.4);
  s.flow.driving = Driving::bulk_velocity;
  s.flow.bulk_velocity = 1.0;
  Channel<double> channel(s, MPI_COMM_WORLD);
  advance(channel, 2);
  Statistics<double> statistics(channel.settings(), channel.grid(), channel.decomposition());
  // The trapezoidal rule over time, as the balance is one of the time between two samples.
  const auto view = [&] { return view_of(std::as_const(channel)); };
  const int steps = 10;
  statistics.sample(view(), {}, 0.5);
  for (int n = 1; n <= steps; ++n) {
    advance(channel, 1);
    statistics.sample(view(), {}, n == steps ? 0.5 : 1.0);
  }
  const FlowStatistics r = statistics.result();
  double largest = 0.0, turbulent = 0.0, gained = 0.0;
  for (std::size_t j = 0; j < r.y.size(); ++j) {
    const double flux = (r.turbulent[j + 1] - r.turbulent[j]) / (r.y_face[j + 1] - r.y_face[j]);
    largest = std::max(largest, std::abs(r.spheres[j]));
    turbulent = std::max(turbulent, std::abs(flux));
    gained = std::max(gained, std::abs(r.acceleration[j]));
  }
  EXPECT_GT(turbulent, 0.01);
  EXPECT_GT(gained, 0.005);
  // Driving is the mean of a step, the fluxes are those at its ends: first order in the step, 1 %.
  EXPECT_LT(largest, 0.01 * turbulent);
}
TEST(Statistics, MomentumOfEachPlaneBalances) {
  expect_balance(0.0);
  expect_balance(1.2);
}

/// What the planes' balance leaves for the spheres is, over all planes, the force that the markers
/// give the fluid, and u_tau over spheres is that of the driving force on the depth.
TEST(Statistics, ForceOfSpheresIsWhatTheMarkersGive) {
  Settings s = box({24, 20, 24}, 1.0 / 16, 1e-2, 0.002);
  s.fluid.density = 2.0;
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 0.3;
  s.reference.height = 0.8;
  const std::vector<SphereState> spheres{
      {.tag = 1, .position = {0.7, 0.4, 0.6}, .radius = 0.3, .mobile = false}};
  Channel<double> channel(s, MPI_COMM_WORLD, spheres);
  channel.set_velocity([](int c, const Vec3& x) { return c == 0 ? x[1] * (2.5 - x[1]) : 0.0; });
  advance(channel, 5);
  Statistics<double> statistics(channel.settings(), channel.grid(), channel.decomposition());
  const int steps = 10;
  double impulse = 0.0;
  statistics.sample(view_of(std::as_const(channel)), spheres, 0.5);
  for (int n = 1; n <= steps; ++n) {
    for (int stage = 0; stage < stage_count; ++stage) {
      channel.predict(stage);
      channel.force_spheres(stage);
      channel.project(stage);
      impulse += two_alpha(stage) * 0.002 * channel.forcing().force_of_fixed.x();
    }
    channel.finish_step();
    statistics.sample(view_of(std::as_const(channel)), spheres, n == steps ? 0.5 : 1.0);
  }
  const FlowStatistics r = statistics.result();
  double force = 0.0;
  for (const double f : r.spheres) force += f * channel.grid().cell_volume() * 24 * 24;
  const double given = impulse / (steps * 0.002);
  EXPECT_LT(given, -0.1);
  // The stresses at the ends of each step stand for those within it: first order, some 0.1 %.
  EXPECT_NEAR(force, given, 0.005 * std::abs(given));
  EXPECT_NEAR(r.u_tau.value(), std::sqrt(0.3 * 0.8 / 2.0), 1e-13);
}

/// Averages over the fluid alone, and the share of it, with a sphere across the periodic ends.
TEST(Statistics, SolidPointsAreLeftOut) {
  Settings settings = box({40, 36, 44}, 0.05, 0.01, 0.01);
  set_y_ends(settings, Wall::periodic, Wall::periodic);
  WrittenFlow flow(settings, MPI_COMM_WORLD);
  const std::vector<SphereState> spheres{{.tag = 1, .position = {0.02, 0.9, 2.15}, .radius = 0.5},
                                         {.tag = 2, .position = {1.0, 0.1, 1.0}, .radius = 0.45}};
  const auto inside = [&](const Vec3& x) {
    for (const SphereState& sphere : spheres) {
      Vec3 d = x - sphere.position;
      for (int n = 0; n < 3; ++n) {
        const double length = flow.grid.length[static_cast<std::size_t>(n)];
        d[n] -= length * std::round(d[n] / length);
      }
      if (d.norm() < sphere.radius) return true;
    }
    return false;
  };
  const auto value = [&](int c, const Vec3& x) { return inside(x) ? 100.0 : 1.0 + c; };
  flow.write(value);
  flow.sample(spheres);
  const FlowStatistics s = flow.statistics.result();
  EXPECT_FALSE(s.stress_defect);
  double solid = 0.0;
  for (std::size_t j = 0; j < s.y.size(); ++j) {
    EXPECT_NEAR(s.u[j], 1.0, 1e-12);
    EXPECT_NEAR(s.w[j], 3.0, 1e-12);
    EXPECT_NEAR(s.p[j], 4.0, 1e-12);
    EXPECT_NEAR(s.uu[j], 0.0, 1e-11);
    EXPECT_NEAR(s.v[j + 1], 2.0, 1e-12);
    solid += (1.0 - s.fluid[j]) * 0.05 * 2.0 * 2.2;
  }
  // Products stand on edges, each of two means of two points, some of which lie in a sphere.
  const auto covariance = [&](int a, int b, int j) {
    const double half = 0.5 * flow.grid.h;
    double sum = 0.0, points = 0.0;
    for (int k = 0; k < 44; ++k)
      for (int i = 0; i < 40; ++i) {
        Vec3 edge(flow.grid.centre(i), flow.grid.centre(j), flow.grid.centre(k));
        edge[a] += half;
        edge[b] += half;
        if (inside(edge)) continue;
        const Vec3 along_a = half * Vec3::Unit(a), along_b = half * Vec3::Unit(b);
        sum += 0.25 * (value(a, edge - along_b) + value(a, edge + along_b)) *
               (value(b, edge - along_a) + value(b, edge + along_a));
        points += 1.0;
      }
    return sum / points - (1.0 + a) * (1.0 + b);
  };
  double largest = 0.0;
  for (int j = 0; j < 36; ++j) {
    const auto n = static_cast<std::size_t>(j);
    EXPECT_NEAR(s.uv[n + 1], covariance(0, 1, j), 1e-9);
    EXPECT_NEAR(s.vw[n + 1], covariance(1, 2, j), 1e-9);
    EXPECT_NEAR(s.uw[n], covariance(0, 2, j), 1e-9);
    largest = std::max(largest, std::abs(s.uv[n + 1]));
  }
  EXPECT_GT(largest, 1.0);
  const double volume = 4.0 / 3.0 * M_PI * (std::pow(0.5, 3) + std::pow(0.45, 3));
  EXPECT_NEAR(solid, volume, 0.01 * volume);  // points against a surface: h/R cubed or so
  EXPECT_LT(*std::min_element(s.fluid.begin(), s.fluid.end()), 0.85);
}

/// E(k) dk of a wave of amplitude A is A^2/2 at its wave number, and all of them make the variance.
TEST(Statistics, SpectraHoldTheVarianceWhereTheWaveIs) {
  Settings settings = periodic_box();
  settings.statistics.spectra_heights = {0.2, 1.4};
  WrittenFlow flow(settings, MPI_COMM_WORLD);
  const double kx = 2 * M_PI / flow.grid.length[0], kz = 2 * M_PI / flow.grid.length[2];
  flow.write([&](int c, const Vec3& x) {
    return 3.0 + (c + 1.0) * x[1] * std::cos(3 * kx * x[0]) + 0.5 * std::cos(5 * kz * x[2] + 0.1) +
           0.25 * std::cos(8 * kx * x[0]);  // the shortest wave that 16 cells hold
  });
  flow.sample();
  flow.sample();
  const FlowStatistics s = flow.statistics.result();
  ASSERT_EQ(s.spectra.size(), 2u);
  for (const auto& at : s.spectra)
    for (std::size_t c = 0; c < 3; ++c) {
      const double y = c == 1 ? at.height + 0.5 * flow.grid.h : at.height;
      const double wave = 0.5 * std::pow((double(c) + 1.0) * y, 2);
      EXPECT_NEAR(at.x[c][3] * kx, wave, 1e-12);
      EXPECT_NEAR(at.z[c][5] * kz, 0.125, 1e-12);
      EXPECT_NEAR(at.x[c][2], 0.0, 1e-12);
      // v and w have their x at the centres, half a cell off: the shortest wave vanishes there.
      const double shortest = c == 0 ? 0.0625 : 0.0;
      EXPECT_NEAR(std::accumulate(at.x[c].begin(), at.x[c].end(), 0.0) * kx, wave + shortest,
                  1e-12);
    }
}

/// Spectra count by the time that their samples stand for, and every other sample has one.
TEST(Statistics, SpectraAreWeightedByTheTimeOfTheirSamples) {
  Settings settings = periodic_box();
  settings.statistics.spectra_heights = {0.7};
  settings.statistics.spectra_every = 2;
  WrittenFlow flow(settings, MPI_COMM_WORLD);
  const double kx = 2 * M_PI / flow.grid.length[0];
  for (const auto& [size, duration] : {std::pair{2.0, 3.0}, {100.0, 5.0}, {4.0, 1.0}}) {
    flow.write(
        [&, a = size](int c, const Vec3& x) { return c == 0 ? a * std::cos(2 * kx * x[0]) : 0.0; });
    flow.sample({}, duration);
  }
  const FlowStatistics s = flow.statistics.result();
  // (3 * 2^2 + 1 * 4^2)/(3 + 1)/2
  EXPECT_NEAR(s.spectra.at(0).x[0][2] * kx, 3.5, 1e-12);
}

/// Interrupted and continued, or on any number of ranks: the same numbers.
TEST(Statistics, GoOnAfterARestartAndDoNotKnowTheRanks) {
  Settings settings = periodic_box();
  settings.statistics.spectra_heights = {0.7};
  const auto shape = [](double t) {
    return [t](int c, const Vec3& x) {
      return std::sin(3.0 * x[0] + c + t) + std::cos(2.0 * x[1] * x[2] + t) * (1 + c);
    };
  };
  const std::vector<SphereState> spheres{{.tag = 1, .position = {0.5, 0.8, 0.1}, .radius = 0.4}};
  const test::Folder folder;
  WrittenFlow whole(settings, MPI_COMM_SELF), begun(settings, MPI_COMM_WORLD),
      continued(settings, MPI_COMM_WORLD);
  for (int n = 0; n < 4; ++n) {
    whole.write(shape(n));
    whole.sample(spheres, 0.5 + n);
    WrittenFlow& part = n < 2 ? begun : continued;
    if (n == 2) {
      test::carry_over(begun.statistics, continued.statistics, folder / "statistics.h5",
                       MPI_COMM_WORLD);
      continued.time = begun.time;
    }
    part.write(shape(n));
    part.sample(spheres, 0.5 + n);
  }
  const FlowStatistics a = whole.statistics.result(), b = continued.statistics.result();
  EXPECT_EQ(b.samples, 4);
  EXPECT_EQ(b.begin, a.begin);
  EXPECT_EQ(b.end, a.end);
  const auto same = [](const std::vector<double>& x, const std::vector<double>& y) {
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t n = 0; n < x.size(); ++n) EXPECT_NEAR(x[n], y[n], 1e-11);
  };
  for (const auto member :
       {&FlowStatistics::u, &FlowStatistics::uu, &FlowStatistics::uv, &FlowStatistics::fluid,
        &FlowStatistics::turbulent, &FlowStatistics::acceleration, &FlowStatistics::spheres})
    same(a.*member, b.*member);
  same(a.spectra[0].x[1], b.spectra[0].x[1]);
  same(a.spectra[0].z[2], b.spectra[0].z[2]);
  for (const std::vector<double>& heights : {std::vector{0.7, 0.9}, std::vector{0.9}}) {
    settings.statistics.spectra_heights = heights;
    WrittenFlow other(settings, MPI_COMM_WORLD);
    EXPECT_THROW(test::carry_over(begun.statistics, other.statistics, folder / "statistics.h5",
                                  MPI_COMM_WORLD),
                 UserError);
  }
}

/// A later `statistics.from` begins the averages anew; one within them cannot be met.
TEST(Statistics, BeginAnewFromALaterTime) {
  Settings settings = periodic_box();
  settings.statistics.spectra_heights = {0.7};
  WrittenFlow begun(settings, MPI_COMM_WORLD);
  for (int n = 0; n < 3; ++n) {
    begun.write([](int, const Vec3&) { return 1.0; });
    begun.sample({}, 1.0);
  }
  const FlowStatistics before = begun.statistics.result();
  ASSERT_LT(before.begin, before.end);
  const test::Folder folder;
  const auto samples_from = [&](double from) {
    settings.statistics.from = from;
    WrittenFlow continued(settings, MPI_COMM_WORLD);
    test::carry_over(begun.statistics, continued.statistics, folder / fmt::format("{}.h5", from),
                     MPI_COMM_WORLD);
    return continued.statistics.samples();
  };
  EXPECT_EQ(samples_from(0.5 * before.begin), 3);
  EXPECT_EQ(samples_from(before.begin), 3);
  EXPECT_EQ(samples_from(before.begin * (1.0 + 4e-6)), 3);  // as the refusal below prints it
  EXPECT_EQ(samples_from(before.end + 0.1), 0);
  EXPECT_THROW(samples_from(before.end), UserError);
}

}  // namespace
}  // namespace bedload
