#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/marker_layout.hpp"
#include "fluid/immersed_boundary/stencil.hpp"

namespace bedload {

/// The markers of one velocity component that this rank handles: those whose nearest plane of that
/// component's staggered grid is its own, so that their support ends in the first ghost plane.
/// Sphere after sphere: a sphere's support fits into the first-level cache.
template <class Real>
struct MarkerList {
  /// The markers begin .. end-1 belong to one sphere.
  struct Range {
    int sphere = 0;  ///< index into the list of spheres
    int layout = 0;  ///< index into the list of layouts
    int begin = 0, end = 0;
  };
  std::vector<Range> ranges;
  std::vector<Stencil<Real>> stencil;
  std::vector<std::int32_t> offset;  ///< index into the sphere's layout
  std::vector<Real> volume;          ///< in cells, see marker_volume.hpp
  std::vector<Real> increment;       ///< velocity times cells handed over in the present loop [L/T]
  std::vector<Real> kept_force;      ///< per fluid density, in cells [L/T^2]; marker_force.hpp

  int size() const { return ranges.empty() ? 0 : ranges.back().end; }
  /// The arrays keep their length to the end of the next finish(), so that what is written anew
  /// need not be emptied before.
  void clear() { ranges.clear(); }
  /// Gives the arrays per marker their length, those of volume and increment not yet their values.
  void finish() {
    const auto count = static_cast<std::size_t>(size());
    stencil.resize(count);
    offset.resize(count);
    volume.resize(count);
    increment.resize(count);
  }
  /// Gives back the memory that a list which stays as it is has to spare.
  void shrink() {
    ranges.shrink_to_fit();
    stencil.shrink_to_fit();
    offset.shrink_to_fit();
  }
};

/// The markers of one sphere on both kinds of points of each direction: cell centres and faces.
/// Made once for its three velocity components, each of which takes the faces along its own
/// direction.
template <class Real>
class SphereMarkers {
 public:
  explicit SphereMarkers(const Grid& grid) : grid_(grid) {}

  void place(const Vec3& centre, const MarkerLayout& layout) {
    centre_ = centre;
    layout_ = &layout;
    for (int d = 0; d < 3; ++d)
      for (const bool face : {false, true})
        find_weights(axis(d, face), centre[d], layout.along[static_cast<std::size_t>(d)],
                     weights_[static_cast<std::size_t>(d)][face ? 1 : 0]);
    // Markers beyond a wall are left out: there is no fluid.
    beyond_wall_.clear();
    for (int d = 0; d < 3; ++d) {
      const double length = grid_.length[static_cast<std::size_t>(d)];
      if (grid_.periodic(d) || (centre[d] >= layout.radius && centre[d] <= length - layout.radius))
        continue;
      beyond_wall_.resize(layout.offsets.size());
      for (std::size_t m = 0; m < beyond_wall_.size(); ++m) {
        const double x = centre[d] + layout.offsets[m][d];
        if (x < 0.0 || x > length) beyond_wall_[m] = 1;
      }
    }
  }

  /// Appends those markers that this rank handles for `component`, except those for which
  /// skip(position) is true. `sphere` and `layout` are the numbers that the list keeps.
  template <class Skip>
  void append(MarkerList<Real>& list, const Field<Real>& field, const Decomposition& decomposition,
              int component, int sphere, int layout, Skip skip) const {
    const auto along = [&](int d) -> const AxisWeightArrays<Real>& {
      return weights_[static_cast<std::size_t>(d)][component == d ? 1 : 0];
    };
    const AxisWeightArrays<Real>&x = along(0), &y = along(1), &z = along(2);
    const Real* origin = field.row(0, 0, 0);
    const auto plane = static_cast<std::ptrdiff_t>(field.plane_size());
    const int begin = list.size();
    auto next = static_cast<std::size_t>(begin);
    const std::size_t most = next + layout_->offsets.size();
    if (most > list.stencil.size()) {
      list.stencil.resize(most);
      list.offset.resize(most);
    }
    // Most spheres lie wholly in one block.
    const bool inside = decomposition.holds(y.lowest, z.lowest) &&
                        decomposition.holds(y.highest, z.highest) && beyond_wall_.empty();
    for (std::size_t m = 0; m < layout_->offsets.size(); ++m) {
      if (!inside && (!decomposition.holds(y.nearest[m], z.nearest[m]) ||
                      (!beyond_wall_.empty() && beyond_wall_[m])))
        continue;
      if (skip(centre_ + layout_->offsets[m])) continue;
      const int row = z.nearest[m] - decomposition.first_row();
      const Real* first = field.row(0, row - 1, component);
      const std::ptrdiff_t place =
          first - origin + x.nearest[m] - 1 + (y.nearest[m] - decomposition.first() - 1) * plane;
      list.stencil[next] = {
          .first = static_cast<std::int32_t>(place),
          .rows = {static_cast<std::int32_t>(field.row(0, row, component) - first),
                   static_cast<std::int32_t>(field.row(0, row + 1, component) - first)},
          .x = {x.lower[m], x.upper[m]},
          .y = {y.lower[m], y.upper[m]},
          .z = {z.lower[m], z.upper[m]}};
      list.offset[next++] = static_cast<std::int32_t>(m);
    }
    const int end = static_cast<int>(next);
    if (end > begin)
      list.ranges.push_back({.sphere = sphere, .layout = layout, .begin = begin, .end = end});
  }

 private:
  StencilAxis axis(int direction, bool face) const {
    return stencil_axis(grid_, face ? direction : (direction + 1) % 3, direction);
  }

  const Grid& grid_;
  Vec3 centre_ = Vec3::Zero();
  const MarkerLayout* layout_ = nullptr;
  std::array<std::array<AxisWeightArrays<Real>, 2>, 3> weights_;  ///< by direction: centres, faces
  std::vector<char> beyond_wall_;                                 ///< empty: none is
};

}  // namespace bedload
