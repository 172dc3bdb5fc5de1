#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <unordered_map>
#include <vector>

#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"

namespace bedload {

/// Vector from `from` to `to`, the shortest one where the box is periodic.
inline Vec3 shortest_way(const Grid& grid, const Vec3& from, const Vec3& to) {
  Vec3 way = to - from;
  for (int d = 0; d < 3; ++d)
    if (grid.periodic(d)) {
      const double length = grid.length[static_cast<std::size_t>(d)];
      if (std::abs(way[d]) >= 0.5 * length) way[d] -= length * std::round(way[d] / length);
    }
  return way;
}

/// The place of the periodic box that a point is an image of [L].
inline Vec3 inside_the_box(const Grid& grid, Vec3 point) {
  for (int d = 0; d < 3; ++d) {
    if (!grid.periodic(d)) continue;
    const double length = grid.length[static_cast<std::size_t>(d)];
    point[d] -= length * std::floor(point[d] / length);
    if (point[d] >= length) point[d] = 0.0;  // by rounding, from just below 0
  }
  return point;
}

/// Calls visit(image) for `way` and its images, moved by whole periods, that are shorter than
/// `reach`. In a narrow box a sphere may be beside another one on both sides.
template <class Visit>
void each_image(const Grid& grid, const Vec3& way, double reach, Visit visit) {
  std::array<int, 3> first{}, last{};
  for (std::size_t d = 0; d < 3; ++d) {
    if (!grid.periodic(static_cast<int>(d))) continue;
    const double length = grid.length[d], along = way[static_cast<Eigen::Index>(d)];
    first[d] = static_cast<int>(std::ceil((-reach - along) / length));
    last[d] = static_cast<int>(std::floor((reach - along) / length));
  }
  for (int x = first[0]; x <= last[0]; ++x)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int z = first[2]; z <= last[2]; ++z) {
        const Vec3 image = way + Vec3(x * grid.length[0], y * grid.length[1], z * grid.length[2]);
        if (image.norm() < reach) visit(image);
      }
}

/// Points sorted into cubes so that those near a place are found without looking at all. Only cubes
/// that hold a point take memory: on a rank the box is mostly empty, and where it has no sphere the
/// cubes are as small as a few cells.
class SphereBins {
 public:
  /// Cubes of at least `edge` [L], which is best about the distance that near() is asked for.
  SphereBins(const Grid& grid, double edge) : grid_(grid) {
    for (std::size_t d = 0; d < 3; ++d)
      count_[d] = std::max(1, static_cast<int>(grid.length[d] / edge));
  }

  void insert(const Vec3& position, int index) { bins_[number(place(position))].push_back(index); }

  /// Calls visit(index) for each point within `distance` of `position`, and for some beyond.
  template <class Visit>
  void near(const Vec3& position, double distance, Visit visit) const {
    const std::array<int, 3> middle = place(position);
    std::array<std::array<int, 2>, 3> range;
    for (std::size_t d = 0; d < 3; ++d) range[d] = around(middle[d], d, distance);
    for (int x = range[0][0]; x <= range[0][1]; ++x)
      for (int y = range[1][0]; y <= range[1][1]; ++y)
        for (int z = range[2][0]; z <= range[2][1]; ++z) {
          const auto bin = bins_.find(number({wrapped(x, 0), wrapped(y, 1), wrapped(z, 2)}));
          if (bin == bins_.end()) continue;
          for (const int index : bin->second) visit(index);
        }
  }

 private:
  std::array<int, 3> place(const Vec3& position) const {
    std::array<int, 3> out{};
    for (std::size_t d = 0; d < 3; ++d) {
      const double share = position[static_cast<Eigen::Index>(d)] / grid_.length[d];
      out[d] = std::clamp(static_cast<int>(std::floor(share * count_[d])), 0, count_[d] - 1);
    }
    return out;
  }
  /// First and last cube that reach to `distance` from cube `middle`; beyond an end where periodic,
  /// but none twice.
  std::array<int, 2> around(int middle, std::size_t d, double distance) const {
    const double most = std::ceil(distance * count_[d] / grid_.length[d]);
    if (2.0 * most + 1.0 >= count_[d] && grid_.periodic(static_cast<int>(d)))
      return {0, count_[d] - 1};
    const int first = static_cast<int>(std::max(middle - most, -1.0 * count_[d])),
              last = static_cast<int>(std::min(middle + most, 2.0 * count_[d]));
    if (grid_.periodic(static_cast<int>(d))) return {first, last};
    return {std::max(first, 0), std::min(last, count_[d] - 1)};
  }
  int wrapped(int n, std::size_t d) const {
    return n < 0 ? n + count_[d] : n >= count_[d] ? n - count_[d] : n;
  }
  std::size_t number(const std::array<int, 3>& p) const {
    return (static_cast<std::size_t>(p[1]) * static_cast<std::size_t>(count_[2]) +
            static_cast<std::size_t>(p[2])) *
               static_cast<std::size_t>(count_[0]) +
           static_cast<std::size_t>(p[0]);
  }

  const Grid& grid_;
  std::array<int, 3> count_{};
  std::unordered_map<std::size_t, std::vector<int>> bins_;  ///< by number(), those with points
};

}  // namespace bedload
