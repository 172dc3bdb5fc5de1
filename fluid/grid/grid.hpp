#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fluid/settings/settings.hpp"

namespace bedload {

/// The box and its cells: squares of edge h in x and z, of the same height or stretched along y.
/// Cell (i, j, k) has its centre at ((i+1/2)h, y_centre(j), (k+1/2)h); "face i" of direction d is
/// the upper face of cell i, where component d of the velocity lives. Indices are global,
/// directions are 0 = x (streamwise), 1 = y (wall-normal, up), 2 = z (spanwise).
struct Grid {
  std::array<int, 3> cells{};
  std::array<double, 3> length{};              ///< [L]
  double h = 0.0;                              ///< edge of a cell along x and z [L]
  std::array<std::array<Wall, 2>, 3> walls{};  ///< walls[d][0] lower, [1] upper end
  /// wall_velocity[d][0] of the lower, [1] of the upper wall [L/T]; nothing along d itself.
  std::array<std::array<std::array<double, 3>, 2>, 3> wall_velocity{};
  /// Faces of stretched y from wall to wall, cells[1] + 1 of them [L]; empty: cubes.
  std::vector<double> y_faces{};

  double centre(int cell) const { return (cell + 0.5) * h; }
  double face(int cell) const { return (cell + 1.0) * h; }
  bool periodic(int direction) const {
    return walls[static_cast<std::size_t>(direction)][0] == Wall::periodic;
  }
  bool stretched() const { return !y_faces.empty(); }

  double y_face(int j) const {
    return stretched() ? y_faces[static_cast<std::size_t>(j + 1)] : face(j);
  }
  double y_centre(int j) const {
    return stretched() ? 0.5 * (y_face(j - 1) + y_face(j)) : centre(j);
  }
  /// Height of cell j in h; the cell beyond a wall is as high as the one before it.
  double thickness(int j) const {
    if (!stretched()) return 1.0;
    const int inside = std::clamp(j, 0, cells[1] - 1);
    return (y_face(inside) - y_face(inside - 1)) / h;
  }
  /// Distance of the centres of cells j and j+1 in h.
  double gap(int j) const { return 0.5 * (thickness(j) + thickness(j + 1)); }
  double thinnest() const {
    double least = thickness(0);
    for (int j = 1; j < cells[1] && stretched(); ++j) least = std::min(least, thickness(j));
    return least;
  }
  /// Planes from the lower end up whose cells are cubes.
  int cubic_planes() const {
    int j = stretched() ? 0 : cells[1];
    while (j < cells[1] && std::abs(thickness(j) - 1.0) < 1e-9) ++j;
    return j;
  }
  /// Height up to which all cells are cubes [L].
  double cubes_up_to() const {
    const int planes = cubic_planes();
    return planes < cells[1] ? y_face(planes - 1) : length[1];
  }

  double cell_volume() const { return h * h * h; }  ///< of a cube
  double volume() const { return length[0] * length[1] * length[2]; }
  double cell_count() const { return double(cells[0]) * double(cells[1]) * double(cells[2]); }
  /// The box's volume in cubes h^3.
  double cubes() const {
    return stretched() ? double(cells[0]) * double(cells[2]) * length[1] / h : cell_count();
  }
};

/// Faces y_0 = 0 .. y_n = L that lie closer at the walls that `dense` names, by a hyperbolic
/// tangent (Vinokur, J. Comput. Phys. 50 (1983) 215, its symmetric and its one-sided form): with
/// eta = j/n,
///
///   both walls   y = L/2 (1 + tanh(s (2 eta - 1)) / tanh s)
///   lower wall   y = L (1 + tanh(s (eta - 1)) / tanh s),   upper wall  y = L tanh(s eta) / tanh s
inline std::vector<double> faces_near_walls(int n, double length, double s,
                                            std::array<bool, 2> dense) {
  std::vector<double> faces;
  for (int j = 0; j <= n; ++j) {
    const double eta = double(j) / n;
    const double t = dense[0] && dense[1]
                         ? 0.5 * (1.0 + std::tanh(s * (2.0 * eta - 1.0)) / std::tanh(s))
                     : dense[0] ? 1.0 + std::tanh(s * (eta - 1.0)) / std::tanh(s)
                                : std::tanh(s * eta) / std::tanh(s);
    faces.push_back(length * t);
  }
  faces.front() = 0.0;
  faces.back() = length;
  return faces;
}

/// Ratio of one cell's height to the one below for which `n` cells, the first one of height h times
/// the ratio, fill `length`: h sum_{m=1..n} r^m = length.
inline double growth_ratio(int n, double length, double h) {
  double low = 0.5, high = 2.0;
  for (int trial = 0; trial < 100; ++trial) {
    const double r = 0.5 * (low + high);
    double sum = 0.0;
    for (int m = 1; m <= n; ++m) sum += std::pow(r, m);
    (h * sum < length ? low : high) = r;
  }
  return 0.5 * (low + high);
}

/// Faces of cubes up to the height `uniform` (a whole number of them), growing by a constant ratio
/// above.
inline std::vector<double> faces_above_cubes(int n, double length, double h, double uniform) {
  const int below = static_cast<int>(std::lround(uniform / h));
  const double ratio = growth_ratio(n - below, length - below * h, h);
  std::vector<double> faces;
  for (int j = 0; j <= below; ++j) faces.push_back(j * h);
  for (double height = h * ratio; static_cast<int>(faces.size()) <= n; height *= ratio)
    faces.push_back(faces.back() + height);
  faces.back() = length;
  return faces;
}

inline Grid make_grid(const Settings& settings) {
  const Settings::Boundary& ends = settings.boundary;
  const Settings::Grid& g = settings.grid;
  Grid grid{.cells = g.cells,
            .length = g.length,
            .h = g.length[0] / g.cells[0],
            .walls = {ends.x, ends.y, ends.z},
            .wall_velocity = {{{ends.x_lower_velocity, ends.x_upper_velocity},
                               {ends.y_lower_velocity, ends.y_upper_velocity},
                               {ends.z_lower_velocity, ends.z_upper_velocity}}}};
  if (g.y_stretching > 0.0)
    grid.y_faces = faces_near_walls(g.cells[1], g.length[1], g.y_stretching,
                                    {ends.y[0] == Wall::no_slip, ends.y[1] == Wall::no_slip});
  else if (g.y_uniform > 0.0)
    grid.y_faces = faces_above_cubes(g.cells[1], g.length[1], grid.h, g.y_uniform);
  return grid;
}

}  // namespace bedload
