#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "fluid/grid/sphere_bins.hpp"

namespace bedload {
namespace {

/// Periodic along x and z, walls along y.
Grid box(const std::array<double, 3>& length) {
  Grid grid{.cells = {8, 8, 8}, .length = length, .h = length[0] / 8};
  grid.walls[1] = {Wall::no_slip, Wall::free_slip};
  return grid;
}

/// Of random points all within a distance are visited, through the seams as well, and none twice.
TEST(SphereBins, FindAllPointsNearAPlace) {
  const Grid grid = box({4.0, 2.0, 3.0});
  std::mt19937 bits(7);
  std::uniform_real_distribution<double> random(0.0, 1.0);
  std::vector<Vec3> points;
  for (int n = 0; n < 300; ++n)
    points.emplace_back(4.0 * random(bits), 2.0 * random(bits), 3.0 * random(bits));
  for (const double edge : {0.1, 0.37, 1.3, 9.0}) {
    SphereBins bins(grid, edge);
    for (std::size_t n = 0; n < points.size(); ++n) bins.insert(points[n], static_cast<int>(n));
    for (const double distance : {0.05, 0.4, 1.1})
      for (std::size_t p = 0; p < 30; ++p) {
        const Vec3& place = points[p];
        std::vector<int> visited;
        bins.near(place, distance, [&](int n) { visited.push_back(n); });
        std::sort(visited.begin(), visited.end());
        EXPECT_EQ(std::adjacent_find(visited.begin(), visited.end()), visited.end());
        for (std::size_t n = 0; n < points.size(); ++n)
          if (shortest_way(grid, place, points[n]).norm() < distance)
            EXPECT_TRUE(std::binary_search(visited.begin(), visited.end(), static_cast<int>(n)))
                << edge << ' ' << distance;
      }
  }
}

/// A box of 1e18 cubes, in which two points lie.
TEST(SphereBins, EmptyCubesTakeNoMemory) {
  const Grid grid = box({1e6, 1e6, 1e6});
  SphereBins bins(grid, 1.0);
  bins.insert({0.2, 5.5e5, 3.0}, 1);
  bins.insert({999999.7, 5.5e5, 3.2}, 2);
  std::vector<int> visited;
  bins.near({0.4, 5.5e5, 3.1}, 1.0, [&](int n) { visited.push_back(n); });
  std::sort(visited.begin(), visited.end());
  EXPECT_EQ(visited, (std::vector{1, 2}));
}

}  // namespace
}  // namespace bedload
