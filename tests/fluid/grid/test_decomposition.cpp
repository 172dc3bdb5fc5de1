#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/division.hpp"
#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/settings/errors.hpp"
#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

using testing::ElementsAre;

TEST(DivideEvenly, EvenCostsGiveEvenSlabs) {
  EXPECT_THAT(divide_evenly(std::vector<double>(12, 1.0), 4), ElementsAre(0, 3, 6, 9, 12));
  EXPECT_THAT(divide_evenly(std::vector<double>(10, 1.0), 3), ElementsAre(0, 3, 7, 10));
  EXPECT_THAT(divide_evenly(std::vector<double>(5, 1.0), 1), ElementsAre(0, 5));
}

TEST(DivideEvenly, FollowsTheCost) {
  // A bed of three planes that cost ten times as much: 30 + 9 units, halves of 19.5.
  std::vector<double> cost(12, 1.0);
  std::fill_n(cost.begin(), 3, 10.0);
  EXPECT_THAT(divide_evenly(cost, 2), ElementsAre(0, 2, 12));
  // However lopsided, each part keeps a plane.
  cost.assign(4, 0.0);
  cost[3] = 1.0;
  EXPECT_THAT(divide_evenly(cost, 4), ElementsAre(0, 1, 2, 3, 4));
  cost.assign(4, 0.0);
  cost[0] = 1.0;
  EXPECT_THAT(divide_evenly(cost, 4), ElementsAre(0, 1, 2, 3, 4));
}

TEST(EvenCuts, CutBothDirections) {
  const Grid grid{.cells = {4, 12, 10}};
  const Cuts cuts = even_cuts(grid, 6, 3);
  EXPECT_THAT(cuts.y, ElementsAre(0, 6, 12));
  EXPECT_THAT(cuts.z, ElementsAre(0, 3, 7, 10));
}

/// A number that tells global plane, row, component and column apart.
double label(int j, int k, int c, int i) { return 1e6 * j + 1e3 * k + 10.0 * i + c; }

Grid small_grid(Wall y_end, Wall z_end = Wall::periodic) {
  Settings s = box({6, 9, 10}, 0.5, 1.0, 1.0);
  set_y_ends(s, y_end, y_end);
  s.boundary.z = {z_end, z_end};
  return make_grid(s);
}

template <class Real>
Field<Real> labelled(const Grid& grid, const Decomposition& decomposition) {
  Field<Real> field(grid, decomposition.extent(), 3);
  field.fill(Real(-1));
  for (int j = 0; j < decomposition.planes(); ++j) {
    for (int k = 0; k < decomposition.rows(); ++k)
      for (int c = 0; c < 3; ++c)
        for (int i = 0; i < grid.cells[0]; ++i)
          field.row(j, k, c)[i] = static_cast<Real>(
              label(decomposition.first() + j, decomposition.first_row() + k, c, i));
    wrap_x_ghosts(field, j);
  }
  return field;
}

/// Every ghost, edges and pads included, holds the value of the cell it stands for; what lies
/// beyond a wall is untouched. In every split of the ranks.
TEST(Halo, GhostsAreTheNeighboursCells) {
  for (const int z_parts : splits(world_size()))
    for (const auto& [y_end, z_end] : {std::pair{Wall::no_slip, Wall::periodic},
                                       {Wall::periodic, Wall::periodic},
                                       {Wall::periodic, Wall::free_slip},
                                       {Wall::no_slip, Wall::no_slip}}) {
      const Grid grid = small_grid(y_end, z_end);
      const Decomposition decomposition(grid, MPI_COMM_WORLD,
                                        even_cuts(grid, world_size(), z_parts));
      Field<double> field = labelled<double>(grid, decomposition);
      decomposition.exchange(field);
      const int nx = grid.cells[0], ny = grid.cells[1], nz = grid.cells[2];
      const auto outside = [](Wall end, int n, int cells) {
        return end != Wall::periodic && (n < 0 || n >= cells);
      };
      for (int j = -1; j <= decomposition.planes(); ++j)
        for (int k = -1; k <= decomposition.rows(); ++k)
          for (int c = 0; c < 3; ++c)
            for (int i = -1; i <= nx; ++i) {
              const int plane = decomposition.first() + j, row = decomposition.first_row() + k;
              const bool beyond = outside(y_end, plane, ny) || outside(z_end, row, nz);
              const double expected =
                  beyond ? -1.0 : label((plane + ny) % ny, (row + nz) % nz, c, (i + nx) % nx);
              ASSERT_EQ(field.row(j, k, c)[i], expected) << j << ' ' << k << ' ' << c << ' ' << i;
            }
    }
}

TEST(Decomposition, EveryCellHasOneOwner) {
  const Grid grid = small_grid(Wall::no_slip);
  for (const int z_parts : splits(world_size())) {
    const Decomposition decomposition(grid, MPI_COMM_WORLD, even_cuts(grid, world_size(), z_parts));
    int own = 0;
    for (int j = 0; j < grid.cells[1]; ++j)
      for (int k = 0; k < grid.cells[2]; ++k) own += decomposition.holds(j, k);
    EXPECT_EQ(own, decomposition.planes() * decomposition.rows());
    MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    EXPECT_EQ(own, grid.cells[1] * grid.cells[2]);
  }
}

TEST(FieldLayout, RelabelMovesPlanesWithoutTouchingThem) {
  const Grid grid = small_grid(Wall::no_slip);
  Field<float> field(grid, {3, grid.cells[2]}, 2, 1);
  field.row(1, 2, 1)[3] = 5.0f;
  field.relabel(1);
  EXPECT_EQ(field.row(2, 2, 1)[3], 5.0f);
  field.relabel(-1);
  EXPECT_EQ(field.row(1, 2, 1)[3], 5.0f);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(field.row(0, 0, 0)) % cache_line, 0u);
}

TEST(FieldLayout, WithoutGhostsHoldsItsOwnRowsOnly) {
  const Grid grid = small_grid(Wall::no_slip);
  const int rows = grid.cells[2] / 2;  // of two blocks along z
  Field<float> field(grid, {3, rows}, 2, 0, Ghosts::none);
  const Field<float> with_ghosts(grid, {3, rows}, 2);
  const std::size_t lane = cache_line / sizeof(float);
  EXPECT_EQ(field.component_stride(), with_ghosts.component_stride());
  EXPECT_EQ(field.bytes(), sizeof(float) * (2 * lane + 3 * field.plane_size()));
  EXPECT_EQ(field.plane_size(), static_cast<std::size_t>(rows) * field.row_size());
  const auto label = [](int j, int k, int c) { return static_cast<float>(100 * j + 10 * k + c); };
  for (int j = 0; j < 3; ++j)
    for (int k = 0; k < rows; ++k)
      for (int c = 0; c < 2; ++c) std::fill_n(field.row(j, k, c), grid.cells[0], label(j, k, c));
  for (int j = 0; j < 3; ++j)
    for (int k = 0; k < rows; ++k)
      for (int c = 0; c < 2; ++c)
        EXPECT_EQ(
            std::count(field.row(j, k, c), field.row(j, k, c) + grid.cells[0], label(j, k, c)),
            grid.cells[0]);
}

const Grid bed_grid{.cells = {16, 20, 16},
                    .length = {1.6, 2.0, 1.6},
                    .h = 0.1,
                    .walls = {{{Wall::periodic, Wall::periodic},
                               {Wall::no_slip, Wall::free_slip},
                               {Wall::periodic, Wall::periodic}}}};

/// Fixed spheres in one place on the floor.
std::vector<SphereState> heap(int spheres, double radius = 0.4) {
  return std::vector<SphereState>(
      static_cast<std::size_t>(spheres),
      {.position = {0.8, radius, 0.8}, .radius = radius, .mobile = false});
}

/// A forcing in `loops` loops with a marker for each cell's volume of a shell, times `density`.
Settings::Spheres forcing(int loops, double density = 1.0) {
  return {.forcing_loops = loops, .marker_density = density};
}

// Two slabs, n planes of 256 cells in the lower one; loads in cells, a marker in one loop is 5. A
// cell of the lower slab takes 0.7 up and 0.3 down, one of the upper slab, which carries the plane
// below it along, 0.79 and 0.40. Without spheres n = 11 is best (10 if both paid the same):
// 256 (max(0.7 n, 0.79 (20 - n)) + max(0.3 n, 0.4 (20 - n))) = 2893, 3046 for n = 10, 3072 for 12.
// Spheres of 8 planes come within reach (5 cells) of cuts up to n = 12; the slabs then wait for
// each other between predictor and forcing, whose slowest, all max(n/8, 1 - n/8), comes on top.
//   One sphere, 201 markers, 1005 cells: n = 11 with 2893 + 1005 beats n = 4 with 4874 + 503.
//   Four spheres: n = 4 with 4874 + 2011 beats n = 11 with 2893 + 4021.
// Spheres of 4 planes leave cuts from n = 9 free: ten of them, 2513 cells, cost
// 0.7 256 n + 2513 + 0.4 256 (20 - n), n = 9: 5252; half of them each, n = 2: 5484 + 1257.
TEST(ChooseCuts, WeighsTheSlowestRankOfEachPhase) {
  const auto second_slab = [&](const std::vector<SphereState>& spheres) {
    return choose_cuts(bed_grid, spheres, 2, 1, forcing(1)).y.at(1);
  };
  EXPECT_EQ(second_slab({}), 11);
  EXPECT_EQ(second_slab(heap(1)), 11);
  EXPECT_EQ(second_slab(heap(4)), 4);
  EXPECT_EQ(second_slab(heap(10, 0.2)), 9);
}

TEST(ForcingWork, CountsAllMarkersInTheirPlanesAndRows) {
  const double all = 5.0 * 3.0 * M_PI * 64.0;  // five cells for each of pi (D/h)^2 markers
  const ForcingWork work(bed_grid, heap(3), forcing(1));
  EXPECT_NEAR(work.block(0, 20, 0, 16), all, 1e-9);
  EXPECT_NEAR(work.block(0, 4, 0, 16), 0.5 * all, 1e-9);
  EXPECT_NEAR(work.block(0, 20, 8, 16), 0.5 * all, 1e-9);
  EXPECT_NEAR(work.block(8, 20, 0, 16), 0.0, 1e-9);
  EXPECT_NEAR(work.plane(7), all / 8.0, 1e-9);
  EXPECT_EQ(work.row(3), 0.0);
  EXPECT_NEAR(ForcingWork(bed_grid, heap(3), forcing(2)).block(0, 20, 0, 16), 2.0 * all, 1e-9);
  EXPECT_NEAR(ForcingWork(bed_grid, heap(3), forcing(1, 0.7)).block(0, 20, 0, 16), 0.7 * all, 1e-9);
  std::vector<SphereState> moving = heap(3);
  for (SphereState& sphere : moving) sphere.mobile = true;
  EXPECT_NEAR(ForcingWork(bed_grid, moving, forcing(2)).block(0, 20, 0, 16), (2.0 + 5.0) * all,
              1e-9);
}

// Planes 0 to 7, rows 4 to 11, less than five cells more on each side; through a seam, too.
TEST(ForcingWork, KnowsWhichCutsSpheresCross) {
  const ForcingWork work(bed_grid, heap(1), forcing(1));
  for (int j = 0; j < 20; ++j) EXPECT_EQ(work.crosses_plane(j), j >= 1 && j <= 12) << j;
  for (int k = 0; k < 16; ++k) EXPECT_TRUE(work.crosses_row(k)) << k << ": rows -1 to 16";
  Grid no_floor = bed_grid;
  no_floor.walls[1] = {Wall::periodic, Wall::periodic};
  const ForcingWork around(no_floor, heap(1), forcing(1));
  for (int j = 0; j < 20; ++j) EXPECT_EQ(around.crosses_plane(j), j <= 12 || j >= 16) << j;
}

// Slabs as long as they are not thin: coupling them sends some planes, dividing rows all cells
// twice. More ranks than planes, or markers in few planes, ask for blocks along z.
TEST(ChooseCuts, DividesRowsWhereItPays) {
  const Grid cube{.cells = {64, 64, 64}, .length = {1.0, 1.0, 1.0}, .h = 1.0 / 64};
  EXPECT_EQ(choose_cuts(cube, {}, 4).z_parts(), 1);
  EXPECT_GT(choose_cuts(cube, {}, 64).z_parts(), 1);
  const Grid flat{.cells = {64, 4, 64}, .length = {1.0, 1.0 / 16, 1.0}, .h = 1.0 / 64};
  EXPECT_GE(choose_cuts(flat, {}, 8).z_parts(), 2);
  EXPECT_GT(choose_cuts(bed_grid, heap(1000), 8).z_parts(), 1);
  EXPECT_EQ(choose_cuts(cube, {}, 4, 4).z_parts(), 4);  // as told
}

// The division of one list, whichever rank knows which of its spheres.
TEST(ChooseCuts, RanksAgreeOnSpheresThatNoneKnowsAll) {
  const std::vector<SphereState> all = heap(4);
  const int ranks = size_of(MPI_COMM_WORLD), rank = rank_in(MPI_COMM_WORLD);
  std::vector<SphereState> mine;
  for (std::size_t n = 0; n < all.size(); ++n)
    if (static_cast<int>(n) % ranks == rank) mine.push_back(all[n]);
  const Cuts together = choose_cuts_together(MPI_COMM_WORLD, bed_grid, mine, 1, forcing(1));
  const Cuts alone = choose_cuts(bed_grid, all, ranks, 1, forcing(1));
  EXPECT_EQ(together.y, alone.y);
  EXPECT_EQ(together.z, alone.z);
  if (ranks == 2)
    EXPECT_NE(alone.y, choose_cuts(bed_grid, mine, ranks, 1, forcing(1)).y) << "too easy";
}

TEST(ForcingWork, RanksAddUpTheirSpheres) {
  const int ranks = size_of(MPI_COMM_WORLD), rank = rank_in(MPI_COMM_WORLD);
  const std::vector<SphereState> one = heap(1), none;
  ForcingWork together(bed_grid, rank + 1 == ranks ? one : none, forcing(1));
  together.add_up_on_first(MPI_COMM_WORLD);
  if (rank != 0) return;
  const ForcingWork alone(bed_grid, one, forcing(1));
  EXPECT_EQ(together.block(0, 7, 3, 16), alone.block(0, 7, 3, 16));
  for (int j = 0; j < 20; ++j) {
    EXPECT_EQ(together.plane(j), alone.plane(j));
    EXPECT_EQ(together.crosses_plane(j), alone.crosses_plane(j));
  }
  for (int k = 0; k < 16; ++k) {
    EXPECT_EQ(together.row(k), alone.row(k));
    EXPECT_EQ(together.crosses_row(k), alone.crosses_row(k));
  }
}

TEST(ChooseCuts, RefusesWhatCannotBeDivided) {
  const Grid tiny{.cells = {8, 5, 4}, .length = {8.0, 5.0, 4.0}, .h = 1.0};
  const auto complaint = [&](int ranks, int z_parts) {
    try {
      choose_cuts(tiny, {}, ranks, z_parts);
    } catch (const UserError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(complaint(20, 0), "");
  EXPECT_THAT(complaint(7, 0), testing::HasSubstr("use 6 fluid ranks"));
  EXPECT_THAT(complaint(6, 4), testing::HasSubstr("'ranks.along_z' is 4"));
  EXPECT_THAT(complaint(6, 6), testing::HasSubstr("1 x 6 blocks"));
}

}  // namespace
}  // namespace bedload
