#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

constexpr double pi = std::numbers::pi;

/// A function of one coordinate in [0, 1] and its first three derivatives.
using Shape = std::function<std::array<double, 4>(double)>;

/// sin(w x + a) and its derivatives.
Shape wave(double w, double a) {
  return [=](double x) {
    const double s = std::sin(w * x + a), c = std::cos(w * x + a);
    return std::array{s, w * c, -w * w * s, -w * w * w * c};
  };
}

/// f(1 - x).
Shape turned(const Shape& f) {
  return [f](double x) {
    const std::array<double, 4> d = f(1.0 - x);
    return std::array{d[0], -d[1], d[2], -d[3]};
  };
}

/// For the stream function along a direction with these ends: zero at a wall, and with it the first
/// derivative (no slip) or the second (free slip).
Shape stream_shape(const std::array<Wall, 2>& ends) {
  if (ends == periodic) return wave(2.0 * pi, 0.4);
  if (ends == free_slip) return wave(pi, 0.0);
  if (ends == no_slip)  // sin^2(pi x)
    return [](double x) {
      const double s = std::sin(2.0 * pi * x), c = std::cos(2.0 * pi * x);
      return std::array{0.5 * (1.0 - c), pi * s, 2.0 * pi * pi * c, -4.0 * pi * pi * pi * s};
    };
  const Shape clamped = [](double x) {  // 3 x^2 - 5 x^3 + 2 x^4: no slip at 0, free slip at 1
    return std::array{x * x * (3.0 - 5.0 * x + 2.0 * x * x), x * (6.0 - 15.0 * x + 8.0 * x * x),
                      6.0 - 30.0 * x + 24.0 * x * x, -30.0 + 48.0 * x};
  };
  return ends == open_channel ? clamped : turned(clamped);
}

/// For the velocity in the plane of walls with these ends: zero (no slip) or flat (free slip).
Shape tangent_shape(const std::array<Wall, 2>& ends) {
  if (ends == periodic) return wave(2.0 * pi, 1.1);
  if (ends == free_slip) return wave(pi, 0.5 * pi);
  if (ends == no_slip) return wave(pi, 0.0);
  return ends == open_channel ? wave(0.5 * pi, 0.0) : wave(0.5 * pi, 0.5 * pi);
}

/// A steady flow in the unit cube without pressure, which swirls in the plane of directions a and b
/// (the stream function is A(a) B(b) T(t), t the third direction),
///
///   u_a = A B' T,   u_b = -A' B T,   u_t = 0,
///
/// and the force per mass that keeps it: f = (u . grad) u - nu lap u.
struct Swirl {
  int a, b, t;
  Shape A, B, T;
  double nu;

  Swirl(const Ends& ends, int third, double viscosity)
      : a((third + 1) % 3), b((third + 2) % 3), t(third), nu(viscosity) {
    A = stream_shape(ends[static_cast<std::size_t>(a)]);
    B = stream_shape(ends[static_cast<std::size_t>(b)]);
    T = tangent_shape(ends[static_cast<std::size_t>(t)]);
  }
  double velocity(int c, const Vec3& x) const {
    if (c == t) return 0.0;
    const auto p = A(x[a]), q = B(x[b]), r = T(x[t]);
    return c == a ? p[0] * q[1] * r[0] : -p[1] * q[0] * r[0];
  }
  double force(int c, const Vec3& x) const {
    if (c == t) return 0.0;
    const auto p = A(x[a]), q = B(x[b]), r = T(x[t]);
    const double ua = p[0] * q[1] * r[0], ub = -p[1] * q[0] * r[0];
    if (c == a)
      return ua * p[1] * q[1] * r[0] + ub * p[0] * q[2] * r[0] -
             nu * (p[2] * q[1] * r[0] + p[0] * q[3] * r[0] + p[0] * q[1] * r[2]);
    return -ua * p[2] * q[0] * r[0] - ub * p[1] * q[1] * r[0] +
           nu * (p[3] * q[0] * r[0] + p[1] * q[2] * r[0] + p[1] * q[0] * r[2]);
  }
};

/// Rms error of a swirl on n^3 cells at t = 0.25, from the exact field. The force joins between
/// predictor and projection, as spheres do.
double swirl_error(int n, const Ends& ends, int third, double stretching, Diffusion diffusion) {
  const double nu = 0.05, end = 0.25;
  const int steps = 3 * n * n / 16;  // nu dt/h^2 = 0.067: the error in time falls with h^2, too
  Settings s = box({n, n, n}, 1.0 / n, nu, end / steps);
  set_ends(s, ends);
  s.grid.y_stretching = stretching;
  s.fluid.diffusion = diffusion;
  const Swirl swirl(ends, third, nu);
  Channel<double> channel(s, MPI_COMM_WORLD);
  channel.set_velocity([&](int c, const Vec3& x) { return swirl.velocity(c, x); });
  const Grid& grid = channel.grid();
  const Decomposition& decomposition = channel.decomposition();
  const WallGhosts<double> walls(grid, decomposition);
  Field<double> force(grid, decomposition.extent(), 3);
  for (int j = 0; j < decomposition.planes(); ++j)
    for (int k = 0; k < decomposition.rows(); ++k)
      for (int c = 0; c < 3; ++c)
        for (int i = 0; i < n; ++i) {
          const int plane = decomposition.first() + j, line = decomposition.first_row() + k;
          const Vec3 place(c == 0 ? grid.face(i) : grid.centre(i),
                           c == 1 ? grid.y_face(plane) : grid.y_centre(plane),
                           c == 2 ? grid.face(line) : grid.centre(line));
          force.row(j, k, c)[i] = swirl.force(c, place);
        }
  for (int step = 0; step < steps; ++step) {
    for (int stage = 0; stage < stage_count; ++stage) {
      const double dt =
          runge_kutta[static_cast<std::size_t>(stage)].two_alpha * channel.time_step();
      channel.predict(stage, true);
      Field<double>& u = channel.fields_to_restore()[Stored::velocity];
      for (int j = 0; j < decomposition.planes(); ++j) {
        for (int k = 0; k < decomposition.rows(); ++k)
          for (int c = 0; c < 3; ++c) {
            double* row = u.row(j, k, c);
            const double* f = force.row(j, k, c);
            for (int i = 0; i < n; ++i) row[i] += dt * f[i];
            walls.close_row(row, c);
          }
        walls.close_plane(u, j);
        if (decomposition.at_upper_wall() && j == decomposition.planes() - 1)
          for (int k = 0; k < decomposition.rows(); ++k)
            std::fill_n(u.row(j, k, 1) - 1, n + 2, 0.0);
      }
      channel.project(stage);
    }
    channel.finish_step();
  }
  return rms_error<double>(channel, [&](int c, const Vec3& x) { return swirl.velocity(c, x); });
}

void expect_second_order(const Ends& ends, int third, double stretching, Diffusion diffusion) {
  const double coarse = swirl_error(12, ends, third, stretching, diffusion);
  const double fine = swirl_error(24, ends, third, stretching, diffusion);
  const double order = std::log2(coarse / fine);
  const std::string which = fmt::format(
      "{} swirl across {} stretching {} {}: {} {}", name_of(ends), "xyz"[third], stretching,
      diffusion == Diffusion::implicit ? "implicit" : "explicit", coarse, fine);
  EXPECT_GT(order, 1.85) << which;
  EXPECT_LT(order, 2.2) << which;
  EXPECT_LT(fine, 0.015) << which;  // of velocities up to 3
}

/// Each kind of end takes part normal to the swirl's plane and within it, along every direction.
TEST(Manufactured, SecondOrderForEveryKindOfEnd) {
  const std::array kinds{periodic, no_slip, free_slip, open_channel, under_a_lid};
  for (std::size_t n = 0; n < kinds.size(); ++n)
    for (int third = 0; third < 3; ++third)
      expect_second_order({kinds[n], kinds[(n + 1) % 5], kinds[(n + 3) % 5]}, third, 0.0,
                          Diffusion::explicit_);
}

TEST(Manufactured, SecondOrderWithImplicitDiffusion) {
  for (const Ends& ends : {Ends{no_slip, no_slip, no_slip}, Ends{periodic, open_channel, periodic},
                           Ends{under_a_lid, free_slip, open_channel}})
    expect_second_order(ends, 2, 0.0, Diffusion::implicit);
}

TEST(Manufactured, SecondOrderOnStretchedY) {
  for (const auto& y : {no_slip, open_channel, under_a_lid})
    for (const Diffusion diffusion : {Diffusion::explicit_, Diffusion::implicit})
      expect_second_order({periodic, y, no_slip}, diffusion == Diffusion::implicit ? 0 : 2, 1.2,
                          diffusion);
}

}  // namespace
}  // namespace bedload
