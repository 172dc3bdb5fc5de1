#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "fluid/decomposition.hpp"
#include "fluid/sphere.hpp"
#include "fluid/spheres/marker_layout.hpp"
#include "fluid/spheres/stencil.hpp"

namespace bedload {

/// The markers of one velocity component that this rank handles: those whose nearest cell of that
/// component's staggered grid is its own, so that their support ends in the first ghosts. Sphere
/// after sphere: a sphere's support fits into the first-level cache.
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
  std::vector<std::int32_t> arm;  ///< index into the sphere's layout
  std::vector<Real> volume;       ///< in cells, see marker_volume.hpp
  std::vector<Real> change;       ///< velocity times cells handed over in the present loop [L/T]
  std::vector<Real> given;        ///< and in all loops of the stage so far

  int size() const { return static_cast<int>(stencil.size()); }
  void clear() {
    ranges.clear();
    stencil.clear();
    arm.clear();
  }
  /// Gives the arrays per marker their length.
  void finish() {
    volume.assign(stencil.size(), Real{1});
    change.assign(stencil.size(), Real{});
    given.assign(stencil.size(), Real{});
  }
};

/// Appends those markers of the sphere `sphere` at `centre` [L], laid out as layouts[layout], that
/// this rank handles for `component`, except those for which skip(position) is true. Markers beyond
/// a wall are left out: there is no fluid.
template <class Real, class Skip>
void append_markers(MarkerList<Real>& list, const Field<Real>& field, const Grid& grid,
                    const Decomposition& slabs, int component, const Vec3& centre, int sphere,
                    int layout, const std::vector<MarkerLayout>& layouts, Skip skip) {
  const std::array<StencilAxis, 3> axes{stencil_axis(grid, component, 0),
                                        stencil_axis(grid, component, 1),
                                        stencil_axis(grid, component, 2)};
  const auto beyond_wall = [&grid](const Vec3& p) {
    for (int d = 0; d < 3; ++d)
      if (!grid.periodic(d) && (p[d] < 0.0 || p[d] > grid.length[static_cast<std::size_t>(d)]))
        return true;
    return false;
  };
  const int begin = list.size();
  const std::vector<Vec3>& arms = layouts[static_cast<std::size_t>(layout)].arms;
  for (std::size_t m = 0; m < arms.size(); ++m) {
    const Vec3 position = centre + arms[m];
    const AxisWeights y = axis_weights(axes[1], position.y());
    if (!slabs.holds_plane(y.nearest)) continue;
    const AxisWeights z = axis_weights(axes[2], position.z());
    if (!slabs.holds_row(z.nearest) || beyond_wall(position) || skip(position)) continue;
    list.stencil.push_back(make_stencil(field, component, axis_weights(axes[0], position.x()),
                                        y.nearest - slabs.first(), y, z.nearest - slabs.first_row(),
                                        z));
    list.arm.push_back(static_cast<std::int32_t>(m));
  }
  if (list.size() > begin)
    list.ranges.push_back({.sphere = sphere, .layout = layout, .begin = begin, .end = list.size()});
}

}  // namespace bedload
