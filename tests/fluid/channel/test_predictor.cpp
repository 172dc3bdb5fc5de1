#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "fluid/channel/predictor.hpp"
#include "fluid/grid/field_list.hpp"
#include "tests/fluid/channel/tiles_case.hpp"

namespace bedload {
namespace {

/// Cells and ghosts of u* from fields of random numbers, predicted as `tiles` say. A row may be
/// used when the row before it and the one below are there.
template <class Real>
std::vector<Real> predicted(const Grid& grid, const Decomposition& decomposition, Tiles tiles,
                            bool old_tendency = true, std::size_t cached = cached_bytes) {
  const int planes = decomposition.planes(), rows = decomposition.rows();
  FlowFields<Real> fields(grid, decomposition.extent());
  Field<Real>&velocity = fields[Stored::velocity], &pressure = fields[Stored::pressure];
  Field<Real> tendency(grid, decomposition.extent(), 3, 0, Ghosts::none);
  std::mt19937 bits(static_cast<unsigned>(decomposition.rank()));
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  for (Field<Real>* field : {&velocity, &pressure, &tendency})
    for (int j = 0; j < planes; ++j)
      for (int k = 0; k < rows; ++k)
        for (int c = 0; c < field->components(); ++c)
          std::generate_n(field->row(j, k, c), grid.cells[0],
                          [&] { return static_cast<Real>(random(bits)); });
  const WallGhosts<Real> walls(grid, decomposition);
  walls.close_own_planes(velocity);
  walls.fill(velocity);
  for (int j = 0; j < planes; ++j) walls.close_scalar(pressure, j);
  decomposition.exchange(pressure);

  Predictor<Real> predictor(grid, decomposition, walls, velocity, tendency, pressure, tiles,
                            cached);
  predictor.begin_stage({.factor = {Real(0.2), Real(0.1), Real(0.3), Real(-0.2), Real(0.4)},
                         .push = {Real(0.1), Real(0), Real(0)},
                         .pressure = true,
                         .old_tendency = old_tendency,
                         .keep_tendency = true});
  std::vector<std::vector<bool>> done(static_cast<std::size_t>(planes + 1));
  for (auto& plane : done) plane.assign(static_cast<std::size_t>(rows + 1), false);
  for (int first = 0; first < planes; first += tiles.planes)
    predictor.planes(first, std::min(first + tiles.planes, planes), [&](int j, int k) {
      const auto plane = static_cast<std::size_t>(j) + 1, row = static_cast<std::size_t>(k) + 1;
      done[plane][row] = true;
      EXPECT_TRUE(j == 0 || done[plane - 1][row]);
      EXPECT_TRUE(k == 0 || done[plane][row - 1]);
    });
  velocity.relabel(1);
  std::vector<Real> values;
  for (int j = 0; j < planes; ++j)
    for (int k = -1; k <= rows; ++k)
      for (int c = 0; c < 3; ++c)
        values.insert(values.end(), velocity.row(j, k, c) - 1,
                      velocity.row(j, k, c) + grid.cells[0] + 1);
  for (int j = 0; j < planes; ++j)
    for (int k = 0; k < rows; ++k)
      for (int c = 0; c < 3; ++c)
        values.insert(values.end(), tendency.row(j, k, c), tendency.row(j, k, c) + grid.cells[0]);
  return values;
}

/// Planes that are predicted at a time, tile by tile, are those that are predicted one after the
/// other.
TEST(Predictor, TilesAgree) {
  expect_equal_tiles([](const auto&... how) { return predicted<double>(how...); });
  expect_equal_tiles([](const auto&... how) { return predicted<float>(how...); });
}

/// A tendency that is written past the caches is the same one.
template <class Real>
void expect_equal_past_caches() {
  const Grid grid = make_grid(box({21, 6, 8}, 0.1, 1e-3, 0.01));
  const Decomposition decomposition(grid, MPI_COMM_WORLD);
  const auto with = [&](std::size_t cached) {
    return predicted<Real>(grid, decomposition, {1, decomposition.rows()}, false, cached);
  };
  EXPECT_EQ(with(0), with(cached_bytes));
}

TEST(Predictor, WritesTheSamePastTheCaches) {
  expect_equal_past_caches<double>();
  expect_equal_past_caches<float>();
}

TEST(Predictor, LargePlanesAreCutIntoTiles) {
  EXPECT_EQ(tiles<double>(192, 192).planes, 1);
  const Tiles large = tiles<double>(1040, 540);
  EXPECT_GT(large.planes, 1);
  EXPECT_LT(large.rows, 20);
  EXPECT_GT(large.rows, 1);
  EXPECT_EQ(pressure_tiles<double>(1040, 135).planes, 1);
  EXPECT_GT(pressure_tiles<double>(1040, 540).planes, 1);
}

}  // namespace
}  // namespace bedload
