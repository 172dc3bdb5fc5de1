#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "fluid/channel/pressure_projection.hpp"
#include "fluid/grid/field_list.hpp"
#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

/// Velocity, its x ghosts and pressure that the projection makes of random numbers, which stand
/// `moved` planes below their places, with planes taken as `tiles` say.
template <class Real>
std::vector<Real> projected(const Grid& grid, const Decomposition& decomposition, Tiles tiles,
                            int moved) {
  const int planes = decomposition.planes(), rows = decomposition.rows(), nx = grid.cells[0];
  FlowFields<Real> fields(grid, decomposition.extent());
  Field<Real>&velocity = fields[Stored::velocity], &pressure = fields[Stored::pressure];
  velocity.relabel(moved);
  std::mt19937 bits(static_cast<unsigned>(decomposition.rank()));
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  const WallGhosts<Real> walls(grid, decomposition);
  for (int j = 0; j < planes; ++j)
    for (int k = 0; k < rows; ++k) {
      std::generate_n(pressure.row(j, k), nx, [&] { return static_cast<Real>(random(bits)); });
      for (int c = 0; c < 3; ++c) {
        std::generate_n(velocity.row(j, k, c), nx, [&] { return static_cast<Real>(random(bits)); });
        walls.close_row(velocity.row(j, k, c), c);
      }
    }
  PhaseClock clock;
  PressureProjection<Real> projection(grid, decomposition, walls, velocity, pressure, clock, tiles,
                                      1);
  projection.begin();
  projection.eliminate_planes(0, planes, 0.1);
  projection.couple();
  projection.correct({.step = 0.1,
                      .shift = 0.2,
                      .measure = true,
                      .moved = moved,
                      .pressure = PressureProjection<Real>::PressureUse::add,
                      .pressure_share = 0.25});
  std::vector<Real> values{static_cast<Real>(projection.local_fastest())};
  for (int j = 0; j < planes; ++j)
    for (int k = 0; k < rows; ++k) {
      for (int c = 0; c < 3; ++c)
        values.insert(values.end(), velocity.row(j, k, c) - 1, velocity.row(j, k, c) + nx + 1);
      values.insert(values.end(), pressure.row(j, k) - 1, pressure.row(j, k) + nx + 1);
    }
  return values;
}

/// Planes that are eliminated, substituted and corrected at a time become what they become one
/// after the other, to the last digit.
template <class Real>
void expect_equal_tiles(const Ends& ends, int z_parts) {
  Settings s = box({18, 24, 22}, 0.1, 1e-3, 0.01);
  set_ends(s, ends);
  const Grid grid = make_grid(s);
  const Decomposition decomposition(grid, MPI_COMM_WORLD, even_cuts(grid, world_size(), z_parts));
  for (const int moved : {0, 1}) {
    const auto one_by_one = projected<Real>(grid, decomposition, {1, decomposition.rows()}, moved);
    for (const Tiles tiles : {Tiles{2, 1}, Tiles{3, 2}, Tiles{8, 5}, Tiles{30, 2}})
      EXPECT_EQ(projected<Real>(grid, decomposition, tiles, moved), one_by_one)
          << tiles.planes << " planes, " << tiles.rows << " rows, moved by " << moved;
  }
}

TEST(Projection, TilesAgree) {
  for (const Ends& ends : {Ends{periodic, open_channel, periodic}, Ends{no_slip, no_slip, no_slip},
                           Ends{periodic, periodic, periodic}})
    for (const int z_parts : splits(world_size())) {
      expect_equal_tiles<double>(ends, z_parts);
      expect_equal_tiles<float>(ends, z_parts);
    }
}

}  // namespace
}  // namespace bedload
