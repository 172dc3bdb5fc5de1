#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "fluid/channel/pressure_projection.hpp"
#include "fluid/grid/field_list.hpp"
#include "tests/fluid/channel/tiles_case.hpp"

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
/// after the other.
TEST(Projection, TilesAgree) {
  for (const int moved : {0, 1}) {
    SCOPED_TRACE(testing::Message() << "moved by " << moved);
    expect_equal_tiles([moved](const auto&... how) { return projected<double>(how..., moved); });
    expect_equal_tiles([moved](const auto&... how) { return projected<float>(how..., moved); });
  }
}

}  // namespace
}  // namespace bedload
