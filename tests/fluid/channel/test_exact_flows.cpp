#include <gtest/gtest.h>

#include <numbers>

#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

constexpr double pi = std::numbers::pi;

/// u of the discrete Poiseuille flow between walls at 0 and L: the parabola G/(2 nu) y (L - y) plus
/// G h^2/(8 nu), because the mean across the wall (not the value on it) is zero.
double discrete_poiseuille(double y, double length, double h, double g, double nu) {
  return g / (2.0 * nu) * (y * (length - y) + 0.25 * h * h);
}

template <class Real>
class ExactFlow : public testing::Test {};
using Precisions = testing::Types<double, float>;
TYPED_TEST_SUITE(ExactFlow, Precisions);

/// The steady state of the scheme is known in closed form, so any departure is round-off: a few
/// hundred steps of diffusion leave some hundred eps.
TYPED_TEST(ExactFlow, PoiseuilleUnderConstantPressureGradientStaysExact) {
  Settings s = box({8, 16, 4}, 0.125, 0.1, 0.01);
  set_y_ends(s, Wall::no_slip, Wall::no_slip);
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 0.3;
  s.fluid.density = 1.5;
  const double g = 0.3 / 1.5;
  const auto exact = [&](int c, const Vec3& x) {
    return c == 0 ? discrete_poiseuille(x[1], 2.0, 0.125, g, 0.1) : 0.0;
  };
  for (const Diffusion diffusion : {Diffusion::explicit_, Diffusion::implicit}) {
    s.fluid.diffusion = diffusion;
    if (diffusion == Diffusion::implicit) s.time.step = 0.2;  // seven times what explicit takes
    Channel<TypeParam> channel(s, MPI_COMM_WORLD);
    channel.set_velocity(exact);
    advance(channel, 200);
    EXPECT_LT(largest_error<TypeParam>(channel, exact), 1000 * epsilon<TypeParam>());
    // Each wall takes half of the driving: rho G L/2 = 0.3 * 2/2.
    const std::array<double, 2> stress = channel.wall_stress();
    EXPECT_NEAR(stress[0], 0.3, 1e4 * epsilon<TypeParam>());
    EXPECT_NEAR(stress[1], 0.3, 1e4 * epsilon<TypeParam>());
    EXPECT_NEAR(channel.driving_force(), 0.3, 1e-12);
  }
}

/// On stretched y and with long steps, too, each wall takes half of the driving and the profile is
/// the parabola to second order: 24 cells, the largest 0.14 high.
TEST(ExactFlow, PoiseuilleOnStretchedYIsReachedImplicitly) {
  Settings s = box({4, 24, 4}, 0.125, 0.5, 0.1);
  s.grid.length[1] = 2.0;
  s.grid.y_stretching = 1.5;
  set_y_ends(s, Wall::no_slip, Wall::no_slip);
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 0.3;
  Channel<double> channel(s, MPI_COMM_WORLD);
  advance(channel, 400);
  const double error = largest_error<double>(
      channel, [](int c, const Vec3& x) { return c == 0 ? 0.3 * x[1] * (2.0 - x[1]) : 0.0; });
  EXPECT_LT(error, 0.3 * 0.14 * 0.14);
  EXPECT_NEAR(channel.wall_stress()[0], 0.3, 1e-12);
  EXPECT_NEAR(channel.wall_stress()[1], 0.3, 1e-12);
}

TEST(ExactFlow, PoiseuilleIsReachedFromRest) {
  Settings s = box({4, 8, 4}, 0.25, 0.5, 0.01);
  set_y_ends(s, Wall::no_slip, Wall::no_slip);
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 0.3;
  Channel<double> channel(s, MPI_COMM_WORLD);
  advance(channel, 3000);  // 30 T: the slowest mode has decayed by exp(-nu pi^2 t/L^2) = 1e-16
  const double error = largest_error<double>(channel, [&](int c, const Vec3& x) {
    return c == 0 ? discrete_poiseuille(x[1], 2.0, 0.25, 0.3, 0.5) : 0.0;
  });
  EXPECT_LT(error, 1e-13);
}

/// Constant bulk velocity in an open channel: the driving must come out as 3 nu U/H^2 (discrete:
/// over 1 + h^2/(2 H^2) * ..., evaluated from the discrete parabola), and the bulk stay exact.
TEST(ExactFlow, OpenChannelFindsItsDrivingForce) {
  const double h = 0.125, nu = 0.2, bulk = 1.3, height = 1.0;
  Settings s = box({4, 8, 4}, h, nu, 0.01);
  s.flow.driving = Driving::bulk_velocity;
  s.flow.bulk_velocity = bulk;
  s.fluid.density = 2.0;
  Channel<double> channel(s, MPI_COMM_WORLD);
  advance(channel, 4000);
  // Half of a closed channel of height 2H; mean of the discrete parabola over the half.
  double mean = 0.0;
  for (int j = 0; j < 8; ++j)
    mean += discrete_poiseuille((j + 0.5) * h, 2.0 * height, h, 1.0, nu) / 8.0;
  EXPECT_NEAR(channel.driving_force(), 2.0 * bulk / mean, 1e-10);
  EXPECT_NEAR(channel.bulk_velocity(), bulk, 1e-13);
  EXPECT_NEAR(channel.wall_stress()[0], channel.driving_force() * height, 1e-10);
  EXPECT_EQ(channel.wall_stress()[1], 0.0);
}

/// Couette flow between walls that move along x and z: linear, and exact on any grid.
TYPED_TEST(ExactFlow, CouetteIsLinear) {
  Settings s = box({4, 8, 4}, 0.25, 0.5, 0.01);
  set_y_ends(s, Wall::no_slip, Wall::no_slip);
  s.boundary.y_lower_velocity = {-0.5, 0.0, 0.25};
  s.boundary.y_upper_velocity = {1.5, 0.0, -0.75};
  for (const double stretching : {0.0, 1.5}) {
    s.grid.y_stretching = stretching;
    s.fluid.diffusion = stretching > 0.0 ? Diffusion::implicit : Diffusion::explicit_;
    Channel<TypeParam> channel(s, MPI_COMM_WORLD);
    advance(channel, 3000);
    const double error = largest_error<TypeParam>(channel, [&](int c, const Vec3& x) {
      const double share = x[1] / 2.0;
      return c == 0 ? -0.5 + 2.0 * share : c == 2 ? 0.25 - share : 0.0;
    });
    EXPECT_LT(error, 500 * epsilon<TypeParam>());
    // Fluid below the faster wall is held back: stress on it nu du/dy = 0.5 (rho = 1), lower the
    // same with the other sign by action and reaction.
    EXPECT_NEAR(channel.wall_stress()[0], 0.5, 1e4 * epsilon<TypeParam>());
    EXPECT_NEAR(channel.wall_stress()[1], -0.5, 1e4 * epsilon<TypeParam>());
  }
}

/// The same between any two walls: along each of the two other directions, the linear profile.
TEST(ExactFlow, CouetteBetweenWallsOfEveryDirection) {
  for (int d = 0; d < 3; ++d) {
    Settings s = box({6, 6, 6}, 0.25, 0.5, 0.01);
    Ends ends{periodic, periodic, periodic};
    ends[static_cast<std::size_t>(d)] = no_slip;
    set_ends(s, ends);
    std::array<double, 3> lower{-0.5, 0.25, 1.0}, upper{1.5, -0.75, -0.25};
    lower[static_cast<std::size_t>(d)] = upper[static_cast<std::size_t>(d)] = 0.0;
    (d == 0   ? s.boundary.x_lower_velocity
     : d == 1 ? s.boundary.y_lower_velocity
              : s.boundary.z_lower_velocity) = lower;
    (d == 0   ? s.boundary.x_upper_velocity
     : d == 1 ? s.boundary.y_upper_velocity
              : s.boundary.z_upper_velocity) = upper;
    Channel<double> channel(s, MPI_COMM_WORLD);
    advance(channel, 2000);
    const double error = largest_error<double>(channel, [&](int c, const Vec3& x) {
      const auto n = static_cast<std::size_t>(c);
      return lower[n] + (upper[n] - lower[n]) * x[d] / 1.5;
    });
    EXPECT_LT(error, 500 * epsilon<double>()) << "walls across "
                                              << "xyz"[d];
  }
}

/// Flow along x through a square duct, against the series solution of the discrete equations'
/// continuous limit: u = sum over odd m, n of 16 G / (pi^4 nu m n ((m/a)^2 + (n/b)^2)) sin sin
/// (Poisson's equation with a constant source). Second order in h, equal in y and z.
TEST(ExactFlow, SquareDuct) {
  const auto centre_error = [](int cells) {
    const double h = 1.0 / cells, nu = 0.5;
    Settings s = box({4, cells, cells}, h, nu, 0.2 * h * h / nu);
    set_ends(s, {periodic, no_slip, no_slip});
    s.flow.driving = Driving::pressure_gradient;
    s.flow.pressure_gradient = 1.0;
    Channel<double> channel(s, MPI_COMM_WORLD);
    advance(channel, 5 * cells * cells);  // one diffusion time 1/nu is exp(-20) of the start
    return largest_error<double>(channel, [&](int c, const Vec3& x) {
      if (c != 0) return 0.0;
      double sum = 0.0;
      for (int m = 1; m < 60; m += 2)
        for (int n = 1; n < 60; n += 2)
          sum += 16.0 / (std::pow(pi, 4) * nu * m * n * (m * m + n * n)) * std::sin(m * pi * x[1]) *
                 std::sin(n * pi * x[2]);
      return sum;
    });
  };
  const double order = std::log2(centre_error(8) / centre_error(16));
  EXPECT_GT(order, 1.8);
  EXPECT_LT(order, 2.2);
}

/// A uniform stream between free-slip walls feels nothing at all.
TEST(ExactFlow, UniformStreamBetweenFreeSlipWallsGoesOn) {
  Settings s = box({8, 6, 4}, 0.25, 0.1, 0.01);
  set_y_ends(s, Wall::free_slip, Wall::free_slip);
  Channel<double> channel(s, MPI_COMM_WORLD);
  const auto stream = [](int c, const Vec3&) { return c == 0 ? 0.7 : c == 2 ? -0.3 : 0.0; };
  channel.set_velocity(stream);
  advance(channel, 50);
  EXPECT_LT(largest_error<double>(channel, stream), 1e-14);
}

/// Largest error after a fixed time of a two-dimensional Taylor-Green vortex in a plane that is
/// turned by `axis`: u_a = U + cos sin, u_b = V - sin cos, carried along and decaying by
/// exp(-2 nu k^2 t).
double taylor_green_error(int cells, int a, int b, double dt, double end) {
  const double h = 1.0 / cells, nu = 0.01, k = 2.0 * pi, drift_a = 0.4,
               drift_b = b == 1 ? 0.0 : 0.3;
  std::array<int, 3> n{4, 4, 4};
  n[static_cast<std::size_t>(a)] = n[static_cast<std::size_t>(b)] = cells;
  Settings s = box(n, h, nu, dt);
  set_y_ends(s, Wall::periodic, Wall::periodic);
  Channel<double> channel(s, MPI_COMM_WORLD);
  double time = 0.0;
  const auto exact = [&](int c, const Vec3& x) {
    const double xa = k * (x[a] - drift_a * time), xb = k * (x[b] - drift_b * time);
    const double size = std::exp(-2.0 * nu * k * k * time);
    if (c == a) return drift_a + size * std::cos(xa) * std::sin(xb);
    if (c == b) return drift_b - size * std::sin(xa) * std::cos(xb);
    return 0.0;
  };
  channel.set_velocity(exact);
  const int steps = static_cast<int>(std::lround(end / dt));
  advance(channel, steps);
  time = channel.time();
  return largest_error<double>(channel, exact);
}

/// Second order in space: the error falls by 2^2 when the cells are halved (the time step with
/// them, its third-order error is far below).
TEST(TaylorGreen, SecondOrderInSpaceInEveryPlane) {
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {0, 2}}) {
    const double coarse = taylor_green_error(16, a, b, 0.01, 0.2);
    const double fine = taylor_green_error(32, a, b, 0.005, 0.2);
    const double order = std::log2(coarse / fine);
    EXPECT_GT(order, 1.85) << "plane " << a << b << ": " << coarse << ' ' << fine;
    EXPECT_LT(order, 2.15) << "plane " << a << b << ": " << coarse << ' ' << fine;
    EXPECT_LT(fine, 5e-3);
  }
}

/// With walls: vortices between free-slip walls across direction b, u_b ~ sin(pi x_b) cos(2 pi
/// x_a), their decay exp(-5 pi^2 nu t), kept in place. The wall rows and the Poisson solver's wall
/// condition take part. Then between walls across both directions.
TEST(TaylorGreen, SecondOrderBetweenFreeSlipWalls) {
  const auto error = [](int cells, double dt, int a, int b, bool closed) {
    const double nu = 0.01, ka = 2.0 * pi, kb = pi;
    std::array<int, 3> n{4, 4, 4};
    n[static_cast<std::size_t>(a)] = n[static_cast<std::size_t>(b)] = cells;
    Settings s = box(n, 1.0 / cells, nu, dt);
    Ends ends{periodic, periodic, periodic};
    ends[static_cast<std::size_t>(b)] = free_slip;
    if (closed) ends[static_cast<std::size_t>(a)] = free_slip;
    set_ends(s, ends);
    Channel<double> channel(s, MPI_COMM_WORLD);
    double time = 0.0;
    const auto exact = [&](int c, const Vec3& x) {
      const double size = std::exp(-nu * (ka * ka + kb * kb) * time);
      if (c == a) return size * kb / ka * std::sin(ka * x[a]) * std::cos(kb * x[b]);
      if (c == b) return -size * std::cos(ka * x[a]) * std::sin(kb * x[b]);
      return 0.0;
    };
    channel.set_velocity(exact);
    advance(channel, static_cast<int>(std::lround(0.2 / dt)));
    time = channel.time();
    return largest_error<double>(channel, exact);
  };
  for (const auto& [a, b] : {std::pair{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}})
    for (const bool closed : {false, true}) {
      const double order =
          std::log2(error(16, 0.01, a, b, closed) / error(32, 0.005, a, b, closed));
      EXPECT_GT(order, 1.85) << a << b << closed;
      EXPECT_LT(order, 2.15) << a << b << closed;
    }
}

/// With no-slip walls: decay of the first shear mode between resting walls, u = sin(pi y), exact
/// for the discrete Laplacian apart from the rate: second order in h.
TEST(TaylorGreen, SecondOrderBetweenNoSlipWalls) {
  const auto error = [](int cells, double dt) {
    const double nu = 0.05;
    Settings s = box({4, cells, 4}, 1.0 / cells, nu, dt);
    set_y_ends(s, Wall::no_slip, Wall::no_slip);
    Channel<double> channel(s, MPI_COMM_WORLD);
    double time = 0.0;
    const auto exact = [&](int c, const Vec3& x) {
      const double size = std::exp(-nu * pi * pi * time);
      return c == 0   ? size * std::sin(pi * x[1])
             : c == 2 ? size * std::sin(2 * pi * x[1]) * std::exp(-3 * nu * pi * pi * time)
                      : 0.0;
    };
    channel.set_velocity(exact);
    advance(channel, static_cast<int>(std::lround(0.4 / dt)));
    time = channel.time();
    return largest_error<double>(channel, exact);
  };
  const double order = std::log2(error(16, 0.004) / error(32, 0.001));
  EXPECT_GT(order, 1.85);
  EXPECT_LT(order, 2.15);
}

/// A wave carried through the fringe leaves a uniform stream behind, and what the fringe takes is
/// in the momentum budget. The box is passed in 2, the fringe in 1, with a mean rate of 10: one
/// passage leaves exp(-10) of the long waves; the short ones that the fringe's edge makes travel
/// slower on this grid, hence some passages.
TEST(ExactFlow, FringeLeavesAUniformStream) {
  Settings s = box({32, 8, 8}, 1.0 / 16, 1e-6, 0.02);
  set_y_ends(s, Wall::periodic, Wall::periodic);
  s.fringe = {.rate = 20.0, .begin = 0.75, .end = 1.75, .velocity = 1.0};
  const auto stream = [](int c, const Vec3&) { return c == 0 ? 1.0 : 0.0; };
  Channel<double> channel(s, MPI_COMM_WORLD);
  channel.set_velocity(
      [&](int c, const Vec3& x) { return c == 0 ? 0.9 : 0.1 * std::sin(pi * x[0] + c); });
  EXPECT_GT(largest_error<double>(channel, stream), 0.05);
  double residual = 0.0;
  for (int n = 0; n < 250; ++n) {
    advance(channel, 1);
    residual = std::max(residual, std::abs(channel.momentum_residual()));
  }
  EXPECT_LT(residual, 1e-14);
  EXPECT_LT(largest_error<double>(channel, stream), 3e-3);
}

/// One stage of it: q + share (U - q) with share = lambda dt/(1 + lambda dt), lambda at the point's
/// own x; the momentum budget also where planes differ in height.
TEST(ExactFlow, FringeDrawsByItsFormula) {
  Settings s = box({16, 8, 8}, 0.125, 0.01, 0.02);
  set_y_ends(s, Wall::free_slip, Wall::free_slip);
  s.grid.y_stretching = 1.3;
  s.fringe = {.rate = 3.0, .begin = 0.5, .end = 1.5, .velocity = 0.7};
  const Grid grid = make_grid(s);
  Fringe<double> fringe(s.fringe, grid);
  Field<double> velocity(grid, {8, 8}, 3);
  velocity.fill(0.2);
  fringe.apply(velocity, 0, 0.4);
  for (int i = 0; i < 16; ++i)
    for (int c = 0; c < 3; ++c) {
      const double x = 0.125 * (c == 0 ? i + 1.0 : i + 0.5);
      const double sine = x > 0.5 && x < 1.5 ? std::sin(pi * (x - 0.5)) : 0.0;
      const double pull = 3.0 * sine * sine * 0.4, target = c == 0 ? 0.7 : 0.0;
      EXPECT_NEAR(velocity.row(3, 4, c)[i], (0.2 + pull * target) / (1.0 + pull), 1e-15);
    }

  Channel<double> channel(s, MPI_COMM_WORLD);
  channel.set_velocity([](int c, const Vec3& x) { return c == 0 ? 0.3 + 0.2 * x[1] : 0.0; });
  const double before = channel.bulk_velocity();
  advance(channel, 1);
  EXPECT_GT(channel.bulk_velocity(), before + 1e-3);
  EXPECT_LT(std::abs(channel.momentum_residual()), 1e-14);
}

}  // namespace
}  // namespace bedload
