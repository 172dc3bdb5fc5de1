#pragma once

#include "fluid/grid/grid.hpp"
#include "fluid/poisson/basis.hpp"

namespace bedload {

/// One row of h^2 d^2/dy^2 on a component's points, times `mass` (the height around the point over
/// h) so that it is symmetric:
///
///   mass (h^2 d^2 x/dy^2)_j = lower x_j-1 + diagonal x_j + upper x_j+1,
///
/// walls taken in: zero gradient (pressure, free slip), zero half a cell outside (no slip) or zero
/// on the next point (v). All ones and minus twos on cubes away from walls.
struct YRow {
  double lower, diagonal, upper, mass;
};

/// Row of global plane j for a velocity component or the pressure. The upper wall's own v is no
/// unknown; its row says x = 0 for a right-hand side of zero.
inline YRow y_row(const Grid& grid, int component, int j) {
  const int n = grid.cells[1];
  const bool at_lower = !grid.periodic(1) && j == 0, at_upper = !grid.periodic(1) && j == n - 1;
  if (component == 1) {
    if (at_upper) return {0.0, -1.0, 0.0, 0.0};
    const double below = 1.0 / grid.thickness(j), above = 1.0 / grid.thickness(j + 1);
    return {at_lower ? 0.0 : below, -below - above, above, grid.gap(j)};
  }
  const double below = 1.0 / grid.gap(j - 1), above = 1.0 / grid.gap(j);
  YRow row{below, -below - above, above, grid.thickness(j)};
  const auto close = [&](std::size_t end, double& neighbour) {
    const bool zero = component != pressure_component && grid.walls[1][end] == Wall::no_slip;
    row.diagonal += zero ? -neighbour : neighbour;  // x beyond = -x or x
    neighbour = 0.0;
  };
  if (at_lower) close(0, row.lower);
  if (at_upper) close(1, row.upper);
  return row;
}

}  // namespace bedload
