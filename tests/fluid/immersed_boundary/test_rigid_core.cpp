// The core of a sphere: which cells it is, what they get, and how much that is.

#include <gtest/gtest.h>
#include <mpi.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/immersed_boundary/excess_spin.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"
#include "fluid/immersed_boundary/marker_layout.hpp"
#include "fluid/immersed_boundary/rigid_core.hpp"
#include "tests/fluid/splits.hpp"

namespace bedload {
namespace {

constexpr double h = 0.1, radius = 0.45;

Grid box(Wall along_y) {
  Settings settings;
  settings.grid.cells = {24, 20, 16};
  settings.grid.length = {2.4, 2.0, 1.6};
  settings.boundary.y = {along_y, along_y};
  return make_grid(settings);
}

/// A value that no motion of a sphere has.
double unlike(int c, const Vec3& x) {
  return 7.0 + c + std::sin(3.0 * x.x() + 5.0 * x.y() - x.z());
}

/// The vector from a centre to a value of component c, by the nearest image where periodic.
Vec3 from_centre(const Grid& grid, int c, const std::array<int, 3>& cell, const Vec3& centre) {
  Vec3 r;
  for (int d = 0; d < 3; ++d) {
    const auto n = static_cast<std::size_t>(d);
    r[d] = (d == c ? grid.face(cell[n]) : grid.centre(cell[n])) - centre[d];
    if (grid.periodic(d)) r[d] -= grid.length[n] * std::round(r[d] / grid.length[n]);
  }
  return r;
}

/// Carries one core through a field of `unlike` and compares all values of this block. The change
/// that is told, summed over the ranks, comes back.
FluidChange check_core(const Grid& grid, const SphereState& sphere, int z_parts) {
  const Decomposition decomposition(grid, MPI_COMM_WORLD,
                                    even_cuts(grid, size_of(MPI_COMM_WORLD), z_parts));
  Field<double> velocity(grid, decomposition.extent(), 3);
  FluidChange expected;
  int inside = 0;
  const auto each = [&](auto use) {
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < decomposition.planes(); ++j)
        for (int k = 0; k < decomposition.rows(); ++k)
          for (int i = 0; i < grid.cells[0]; ++i) {
            const int plane = decomposition.first() + j, row = decomposition.first_row() + k;
            const Vec3 x(grid.centre(i), grid.centre(plane), grid.centre(row));
            const bool wall = c == 1 && !grid.periodic(1) && plane == grid.cells[1] - 1;
            use(c, velocity.row(j, k, c)[i], wall ? 0.0 : unlike(c, x), wall,
                from_centre(grid, c, {i, plane, row}, sphere.position));
          }
  };
  each([](int, double& u, double before, bool, const Vec3&) { u = before; });
  FluidChange told = carry_core(velocity, grid, decomposition, sphere, radius);
  each([&](int c, double u, double before, bool wall, const Vec3& r) {
    if (r.norm() > radius || wall) {
      EXPECT_EQ(u, before);
      return;
    }
    ++inside;
    EXPECT_NEAR(u, (sphere.velocity + sphere.angular_velocity.cross(r))[c], 1e-13);
    const Vec3 change = (u - before) * Vec3::Unit(c);
    expected.linear += change;
    expected.angular += r.cross(change);
  });
  MPI_Allreduce(MPI_IN_PLACE, &inside, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_GT(inside, 500);
  EXPECT_NEAR((told.linear - expected.linear).norm(), 0.0, 1e-10);
  EXPECT_NEAR((told.angular - expected.angular).norm(), 0.0, 1e-10);
  for (Vec3* sum : {&told.linear, &told.angular})
    MPI_Allreduce(MPI_IN_PLACE, sum->data(), 3, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return told;
}

SphereState turning(const Vec3& position) {
  return {.tag = 1,
          .position = position,
          .velocity = {0.3, -0.2, 0.5},
          .angular_velocity = {1.1, -0.7, 0.4},
          .radius = radius + core_depth * h};
}

TEST(Forcing, ACoreMovesAsItsSphereOnAnyRanks) {
  const Vec3 places[]{{1.2313, 1.0417, 0.7729}, {2.3623, 1.9631, 0.0519}, {0.0427, 0.0713, 1.5811}};
  for (const Vec3& place : places) {
    const FluidChange told = check_core(box(Wall::periodic), turning(place), 1);
    EXPECT_GT(told.linear.norm(), 1000.0);
    for (const int z_parts : splits(size_of(MPI_COMM_WORLD)))
      EXPECT_NEAR(
          (check_core(box(Wall::periodic), turning(place), z_parts).linear - told.linear).norm(),
          0.0, 1e-9);
  }
}

TEST(Forcing, ACoreThatAWallCutsLeavesTheWallAloneOnAnyRanks) {
  check_core(box(Wall::no_slip), turning({1.2317, 0.1133, 0.7729}), 1);
  check_core(box(Wall::no_slip), turning({2.3119, 1.8741, 1.5523}), 1);
}

/// One forcing of fluid at rest by a sphere in the middle of the box.
double speed_in_the_middle(bool mobile, bool rigid_core) {
  const Grid grid = box(Wall::periodic);
  Settings settings;
  settings.spheres.rigid_core = rigid_core;
  const Decomposition decomposition(grid, MPI_COMM_SELF);
  Field<double> velocity(grid, decomposition.extent(), 3);
  ImmersedBoundary<double> boundary(settings, grid, decomposition);
  SphereState sphere = turning({1.2, 1.0, 0.8});
  sphere.mobile = mobile;
  boundary.set_spheres(std::vector<SphereState>{sphere});
  boundary.start_stage(velocity);
  boundary.force(velocity, 0.01, 0.01);
  return velocity.row(10, 8, 0)[11];  // at the height y - 0.05 and z + 0.05 of the centre
}

TEST(RigidCore, IsCarriedByEachForcingUnlessSwitchedOff) {
  for (const bool mobile : {true, false}) {
    // u = 0.3 + omega_y z - omega_z y
    EXPECT_DOUBLE_EQ(speed_in_the_middle(mobile, true), 0.3 - 0.7 * 0.05 - 0.4 * 0.05);
    EXPECT_EQ(speed_in_the_middle(mobile, false), 0.0);
  }
}

TEST(RigidCore, PullsMarkersIn) {
  EXPECT_DOUBLE_EQ(default_retraction(4.0, 0.0), 0.29 + 0.125);
  EXPECT_DOUBLE_EQ(default_retraction(6.0, 3.0), 0.29 + 1.0 / 12.0 + 0.13 * 0.25);
  EXPECT_DOUBLE_EQ(torque_deficit(6.0, 3.0), 1.0 / 36.0 + 0.31 * 0.25 / 6.0);
}

/// Where the markers of a resting sphere are, seen from outside: in u = x - x_c, which the kernel
/// interpolates exactly, the largest slip is their largest coordinate. Without the core's share of
/// the retraction it would be 0.05 cells more at this size, R/h = 8.
TEST(RigidCore, PullsTheMarkersOfASphereIn) {
  Settings settings;
  settings.grid.cells = {24, 24, 24};
  settings.grid.length = {2.4, 2.4, 2.4};
  settings.boundary.y = {Wall::periodic, Wall::periodic};
  const Grid grid = make_grid(settings);
  const Decomposition decomposition(grid, MPI_COMM_SELF);
  const Vec3 centre(1.213, 1.187, 1.204);
  const double large = 8.0 * h;
  for (const bool mobile : {true, false}) {
    ImmersedBoundary<double> boundary(settings, grid, decomposition);
    boundary.set_spheres(std::vector<SphereState>{
        {.tag = 1, .position = centre, .radius = large, .mobile = mobile}});
    Field<double> velocity(grid, decomposition.extent(), 3);
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < 24; ++j)
        for (int k = 0; k < 24; ++k)
          for (int i = 0; i < 24; ++i)
            velocity.row(j, k, c)[i] = from_centre(grid, c, {i, j, k}, centre)[c];
    double farthest = 0.0;
    for (const Vec3& offset :
         make_marker_layout(large, h, -1.0, core_radius(8.0), settings.spheres.marker_density)
             .offsets)
      farthest = std::max(farthest, offset.cwiseAbs().maxCoeff());
    EXPECT_LT(farthest, large - 0.35 * h);
    EXPECT_NEAR(boundary.slip(velocity).max, farthest, 1e-12);
  }
}

TEST(RigidCore, BeginsWhereMarkersReachNoFurther) {
  EXPECT_EQ(core_radius(3.0), 0.0);
  EXPECT_EQ(core_radius(2.0), 0.0);
  EXPECT_DOUBLE_EQ(core_radius(7.5), 4.5);
}

}  // namespace
}  // namespace bedload
