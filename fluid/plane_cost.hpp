#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "fluid/decomposition.hpp"
#include "fluid/grid.hpp"
#include "fluid/sphere.hpp"

namespace bedload {

/// Markers of the spheres that cross each y plane. Those of one sphere, about pi (D/h)^2 of them,
/// are spread evenly over its height (Archimedes).
inline std::vector<double> markers_per_plane(const Grid& grid,
                                             std::span<const SphereState> spheres) {
  const int planes = grid.cells[1];
  std::vector<double> markers(static_cast<std::size_t>(planes), 0.0);
  for (const SphereState& sphere : spheres) {
    const double diameter = 2.0 * sphere.radius / grid.h;  // in planes
    const double low = sphere.position[1] / grid.h - 0.5 * diameter, high = low + diameter;
    for (int j = static_cast<int>(std::floor(low)); j < high; ++j) {
      const double share = std::min(high, j + 1.0) - std::max(low, double(j));
      const int plane =
          grid.periodic(1) ? ((j % planes) + planes) % planes : std::clamp(j, 0, planes - 1);
      markers[static_cast<std::size_t>(plane)] += share * std::numbers::pi * diameter;
    }
  }
  return markers;
}

/// Cost of every y plane, in cells, to divide the planes by: its cells, and its markers times a
/// weight w. Predictor, markers and pressure wait for each other, so a stage takes
///
///   max over ranks of cells  +  marker_cost * max over ranks of markers,
///
/// and the w between 0 and marker_cost that makes this smallest is taken.
inline std::vector<double> plane_cost(const Grid& grid, std::span<const SphereState> spheres,
                                      int ranks) {
  constexpr double marker_cost = 10.0;  // in cells: two loops against predictor and pressure
  constexpr int trials = 10;
  const double cells = double(grid.cells[0]) * double(grid.cells[2]);
  const std::vector<double> markers = markers_per_plane(grid, spheres);
  std::vector<double> best, cost(markers.size());
  double shortest = std::numeric_limits<double>::infinity();
  for (int trial = 0; trial <= trials; ++trial) {
    for (std::size_t j = 0; j < cost.size(); ++j)
      cost[j] = cells + marker_cost * trial / trials * markers[j];
    const std::vector<int> first = divide_planes(cost, ranks);
    double most_cells = 0.0, most_markers = 0.0;
    for (std::size_t r = 0; r + 1 < first.size(); ++r) {
      most_cells = std::max(most_cells, cells * (first[r + 1] - first[r]));
      most_markers = std::max(most_markers, std::accumulate(markers.begin() + first[r],
                                                            markers.begin() + first[r + 1], 0.0));
    }
    if (most_cells + marker_cost * most_markers < shortest) {
      shortest = most_cells + marker_cost * most_markers;
      best = cost;
    }
  }
  return best;
}

}  // namespace bedload
