#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"

namespace bedload {

/// Which blocks of the divided box a sphere concerns. Plain numbers, so that LIGGGHTS' ranks find
/// the same as the fluid's. Blocks are counted along z first, then along y.
struct BlockMap {
  /// How far outside its radius, in cells, a sphere may still concern a block: what it carries
  /// along is corrected up to 3 cells away, the halo is marked for 4, and markers of others know of
  /// it up to pore_to = 4.
  static constexpr double reach = 5.0;

  std::array<double, 3> length{};  ///< of the box [L]
  std::array<bool, 3> periodic{};
  double h = 0.0;               ///< cell size [L]
  std::vector<int> y{0}, z{0};  ///< first plane and row of each part, and behind the last one

  int y_parts() const { return static_cast<int>(y.size()) - 1; }
  int z_parts() const { return static_cast<int>(z.size()) - 1; }
  int ranks() const { return y_parts() * z_parts(); }

  /// The block that a sphere's centre lies in, or the nearest one where it is beyond a wall.
  int home(const Vec3& centre) const {
    return part_of(1, centre.y(), y) * z_parts() + part_of(2, centre.z(), z);
  }

  /// Calls visit(block) once for each block that a sphere concerns, in ascending order.
  template <class Visit>
  void near(const Vec3& centre, double radius, Visit visit) const {
    near(centre, Vec3::Constant(radius), visit);
  }

  /// The same for anything that reaches `half_width` in each direction from its centre.
  template <class Visit>
  void near(const Vec3& centre, const Vec3& half_width, Visit visit) const {
    const std::vector<int> along_z = parts_near(2, centre.z(), half_width.z(), z);
    for (const int part_y : parts_near(1, centre.y(), half_width.y(), y))
      for (const int part_z : along_z) visit(part_y * z_parts() + part_z);
  }

  bool is_near(int block, const Vec3& centre, double radius) const {
    const std::size_t part_y = static_cast<std::size_t>(block / z_parts());
    const std::size_t part_z = static_cast<std::size_t>(block % z_parts());
    return is_near(1, centre.y(), radius, y, part_y) && is_near(2, centre.z(), radius, z, part_z);
  }

 private:
  int part_of(std::size_t d, double x, const std::vector<int>& first) const {
    const int cells = first.back();
    int cell = static_cast<int>(std::floor(x / h));
    cell = periodic[d] ? ((cell % cells) + cells) % cells : std::clamp(cell, 0, cells - 1);
    return static_cast<int>(std::upper_bound(first.begin(), first.end(), cell) - first.begin()) - 1;
  }
  bool is_near(std::size_t d, double x, double radius, const std::vector<int>& first,
               std::size_t part) const {
    const double cells = first.back(), width = radius / h + reach;
    const double low = x / h - width, high = x / h + width;
    for (const double image : {0.0, -cells, cells}) {
      if (image != 0.0 && !periodic[d]) continue;
      // Beyond a wall there is no other block: those at the wall count as reaching further.
      const bool lowest = !periodic[d] && part == 0;
      const bool highest = !periodic[d] && part + 2 == first.size();
      if ((lowest || first[part] < high + image) && (highest || first[part + 1] > low + image))
        return true;
    }
    return false;
  }
  std::vector<int> parts_near(std::size_t d, double x, double radius,
                              const std::vector<int>& first) const {
    std::vector<int> parts;
    for (std::size_t part = 0; part + 1 < first.size(); ++part)
      if (is_near(d, x, radius, first, part)) parts.push_back(static_cast<int>(part));
    return parts;
  }
};

inline BlockMap block_map(const Grid& grid, const Cuts& cuts) {
  return {.length = grid.length,
          .periodic = {grid.periodic(0), grid.periodic(1), grid.periodic(2)},
          .h = grid.h,
          .y = cuts.y,
          .z = cuts.z};
}

inline BlockMap block_map(const Grid& grid, const Decomposition& decomposition) {
  return block_map(grid, decomposition.cuts());
}

}  // namespace bedload
