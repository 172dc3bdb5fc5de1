#pragma once

#include <array>

#include "fluid/settings.hpp"

namespace bedload {

/// The box and its cubic cells. Cell (i, j, k) has its centre at ((i+1/2)h, (j+1/2)h, (k+1/2)h);
/// "face i" of direction d is the upper face of cell i, at (i+1)h, where component d of the
/// velocity lives. Indices are global, directions are 0 = x (streamwise), 1 = y (wall-normal, up),
/// 2 = z (spanwise).
struct Grid {
  std::array<int, 3> cells{};
  std::array<double, 3> length{};              ///< [L]
  double h = 0.0;                              ///< edge of a cell [L]
  std::array<std::array<Wall, 2>, 3> walls{};  ///< walls[d][0] lower, [1] upper end
  /// wall_velocity[d][0] of the lower, [1] of the upper wall [L/T]; nothing along d itself.
  std::array<std::array<std::array<double, 3>, 2>, 3> wall_velocity{};

  double centre(int cell) const { return (cell + 0.5) * h; }
  double face(int cell) const { return (cell + 1.0) * h; }
  bool periodic(int direction) const {
    return walls[static_cast<std::size_t>(direction)][0] == Wall::periodic;
  }
  double cell_volume() const { return h * h * h; }
  double volume() const { return length[0] * length[1] * length[2]; }
  double cell_count() const { return double(cells[0]) * double(cells[1]) * double(cells[2]); }
};

inline Grid make_grid(const Settings& settings) {
  const Settings::Boundary& ends = settings.boundary;
  return {.cells = settings.grid.cells,
          .length = settings.grid.length,
          .h = settings.grid.length[0] / settings.grid.cells[0],
          .walls = {ends.x, ends.y, ends.z},
          .wall_velocity = {{{ends.x_lower_velocity, ends.x_upper_velocity},
                             {ends.y_lower_velocity, ends.y_upper_velocity},
                             {ends.z_lower_velocity, ends.z_upper_velocity}}}};
}

}  // namespace bedload
