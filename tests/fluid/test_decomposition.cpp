#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "fluid/decomposition.hpp"
#include "fluid/errors.hpp"
#include "fluid/plane_cost.hpp"
#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

using testing::ElementsAre;

TEST(DividePlanes, EvenCostsGiveEvenSlabs) {
  EXPECT_THAT(divide_planes(std::vector<double>(12, 1.0), 4), ElementsAre(0, 3, 6, 9, 12));
  EXPECT_THAT(divide_planes(std::vector<double>(10, 1.0), 3), ElementsAre(0, 3, 7, 10));
  EXPECT_THAT(divide_planes(std::vector<double>(5, 1.0), 1), ElementsAre(0, 5));
}

TEST(DividePlanes, FollowsTheCost) {
  // A bed of three planes that cost ten times as much: 30 + 9 units, halves of 19.5.
  std::vector<double> cost(12, 1.0);
  std::fill_n(cost.begin(), 3, 10.0);
  EXPECT_THAT(divide_planes(cost, 2), ElementsAre(0, 2, 12));
  // However lopsided, each part keeps a plane.
  cost.assign(4, 0.0);
  cost[3] = 1.0;
  EXPECT_THAT(divide_planes(cost, 4), ElementsAre(0, 1, 2, 3, 4));
  cost.assign(4, 0.0);
  cost[0] = 1.0;
  EXPECT_THAT(divide_planes(cost, 4), ElementsAre(0, 1, 2, 3, 4));
}

TEST(DividePlanes, RefusesMoreRanksThanPlanes) {
  EXPECT_THROW(divide_planes(std::vector<double>(3, 1.0), 4), UserError);
}

/// A number that tells global plane, row, component and column apart.
double label(int j, int k, int c, int i) { return 1e6 * j + 1e3 * k + 10.0 * i + c; }

Grid small_grid(Wall y_end) {
  Settings s = box({6, 9, 4}, 0.5, 1.0, 1.0);
  set_y_ends(s, y_end, y_end);
  return make_grid(s);
}

template <class Real>
Field<Real> labelled(const Grid& grid, const Decomposition& slabs) {
  Field<Real> field(grid, slabs.planes(), 3);
  field.fill(Real(-1));
  for (int j = 0; j < slabs.planes(); ++j) {
    for (int k = 0; k < grid.cells[2]; ++k)
      for (int c = 0; c < 3; ++c)
        for (int i = 0; i < grid.cells[0]; ++i)
          field.row(j, k, c)[i] = static_cast<Real>(label(slabs.first() + j, k, c, i));
    wrap_x_ghosts(field, j);
  }
  return field;
}

/// Every ghost, corners and pads included, holds the value of the cell it stands for; what lies
/// beyond a wall is untouched.
TEST(Halo, GhostsAreTheNeighboursCells) {
  for (const Wall end : {Wall::no_slip, Wall::periodic}) {
    const Grid grid = small_grid(end);
    const Decomposition slabs(grid, MPI_COMM_WORLD);
    Field<double> field = labelled<double>(grid, slabs);
    slabs.exchange(field);
    const int nx = grid.cells[0], ny = grid.cells[1], nz = grid.cells[2];
    for (int j = -1; j <= slabs.planes(); ++j)
      for (int k = -1; k <= nz; ++k)
        for (int c = 0; c < 3; ++c)
          for (int i = -1; i <= nx; ++i) {
            const int global = slabs.first() + j;
            const bool beyond = end != Wall::periodic && (global < 0 || global >= ny);
            const double expected =
                beyond ? -1.0 : label((global + ny) % ny, (k + nz) % nz, c, (i + nx) % nx);
            ASSERT_EQ(field.row(j, k, c)[i], expected) << j << ' ' << k << ' ' << c << ' ' << i;
          }
  }
}

/// The reverse exchange is the adjoint of the exchange: <exchange(a), b> = <a, add_ghosts(b)> over
/// all storage on the left, over the cells alone on the right.
TEST(Halo, AddingGhostsIsTheAdjointOfFillingThem) {
  const Grid grid = small_grid(Wall::periodic);
  const Decomposition slabs(grid, MPI_COMM_WORLD);
  Field<double> a = labelled<double>(grid, slabs), b(grid, slabs.planes(), 3);
  const auto weight = [&](int j, int k, int c, int i) {
    return std::sin(1.0 + 3.0 * (slabs.first() + j) + 5.0 * slabs.rank() + k * 7.0 + c * 11.0 + i);
  };
  const auto sum = [&](const Field<double>& f, const Field<double>& g, bool ghosts) {
    const int edge = ghosts ? 1 : 0;
    double total = 0.0;
    for (int j = -edge; j < slabs.planes() + edge; ++j)
      for (int k = 0; k < grid.cells[2]; ++k)
        for (int c = 0; c < 3; ++c)
          for (int i = -edge; i < grid.cells[0] + edge; ++i)
            total += f.row(j, k, c)[i] * g.row(j, k, c)[i];
    MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    return total;
  };
  for (int j = -1; j <= slabs.planes(); ++j)
    for (int k = 0; k < grid.cells[2]; ++k)
      for (int c = 0; c < 3; ++c)
        for (int i = -1; i <= grid.cells[0]; ++i) b.row(j, k, c)[i] = weight(j, k, c, i);
  slabs.exchange(a);
  const double filled = sum(a, b, true);
  slabs.add_ghosts(b);
  EXPECT_NEAR(sum(a, b, false), filled, 1e-9 * std::abs(filled));
  EXPECT_EQ(b.row(-1, 0, 0)[0], 0.0);
  EXPECT_EQ(b.row(slabs.planes(), 1, 2)[3], 0.0);
  EXPECT_EQ(b.row(0, 1, 2)[-1], 0.0);
}

TEST(Halo, EveryPlaneHasOneOwner) {
  const Grid grid = small_grid(Wall::no_slip);
  const Decomposition slabs(grid, MPI_COMM_WORLD);
  for (int j = 0; j < grid.cells[1]; ++j) {
    const int owner = slabs.owner(j);
    EXPECT_GE(j, slabs.first(owner));
    EXPECT_LT(j, slabs.first(owner) + slabs.planes(owner));
    EXPECT_EQ(slabs.holds(j), owner == slabs.rank());
  }
}

TEST(FieldLayout, RelabelMovesPlanesWithoutTouchingThem) {
  const Grid grid = small_grid(Wall::no_slip);
  Field<float> field(grid, 3, 2, 1);
  field.row(1, 2, 1)[3] = 5.0f;
  field.relabel(1);
  EXPECT_EQ(field.row(2, 2, 1)[3], 5.0f);
  field.relabel(-1);
  EXPECT_EQ(field.row(1, 2, 1)[3], 5.0f);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(field.row(0, 0, 0)) % cache_line, 0u);
}

// The phases of a stage wait for each other. Few markers at the floor all go to one rank, whose
// share of the cells stays one half; so many that they rule are halved instead, at the price of the
// cells.
TEST(PlaneCost, WeighsTheSlowestRankOfEachPhase) {
  const Grid grid{.cells = {16, 20, 16}, .length = {1.6, 2.0, 1.6}, .h = 0.1};
  const auto second_slab = [&](int spheres) {
    const std::vector<SphereState> bed(static_cast<std::size_t>(spheres),
                                       {.position = {0.8, 0.4, 0.8}, .radius = 0.4});
    return divide_planes(plane_cost(grid, bed, 2), 2).at(1);
  };
  EXPECT_EQ(second_slab(0), 10);
  EXPECT_EQ(second_slab(1), 10);
  EXPECT_EQ(second_slab(1000), 4);
}

}  // namespace
}  // namespace bedload
