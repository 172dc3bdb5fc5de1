#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <unordered_set>

#include "fluid/grid/mpi_records.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"
#include "fluid/immersed_boundary/marker_volume.hpp"
#include "fluid/immersed_boundary/stopwatch.hpp"
#include "fluid/immersed_boundary/surfaces_beside.hpp"

// Where the spheres' markers are, and how much fluid each of them stands for.

namespace bedload {
namespace {

/// Markers further than this, in cells, from a sphere share no cells of its markers' supports (two
/// supports of 3 cells, less the markers' retraction).
constexpr double shared_reach = 2.5;
static_assert(volume_beside_to <= shared_reach && shared_reach <= pore_to);

/// Largest gap, in cells, between spheres that are neighbours: each of what looks at them has its
/// own reach within it.
constexpr double beside = std::max(2.0 * dispersion_reach, pore_to);

constexpr std::array<std::size_t, 3> components{0, 1, 2};

}  // namespace

/// Index of the layout for a radius, made when it is the first of its size.
template <class Real>
int ImmersedBoundary<Real>::layout_of(double radius) {
  if (const auto known = layout_by_radius_.find(radius); known != layout_by_radius_.end())
    return static_cast<int>(known->second);
  if (layout_by_radius_.size() >= most_layouts_) drop_layouts();
  if (free_layouts_.empty()) {
    free_layouts_.push_back(layouts_.size());
    layouts_.emplace_back();
  }
  const std::size_t place = free_layouts_.back();
  free_layouts_.pop_back();
  layouts_[place] =
      make_marker_layout(radius, grid_.h, retraction_, core_of(radius) / grid_.h, marker_density_);
  layout_by_radius_.emplace(radius, place);
  return static_cast<int>(place);
}

/// Of sizes that no sphere has any more: grains that grow have another one in each stage.
template <class Real>
void ImmersedBoundary<Real>::drop_layouts() {
  std::unordered_set<double> here;
  for (const SphereState& sphere : fixed_) here.insert(sphere.radius);
  for (const Mobile& sphere : mobile_) here.insert(sphere.state.radius);
  std::erase_if(layout_by_radius_, [&](const auto& entry) {
    if (here.contains(entry.first)) return false;
    layouts_[entry.second] = {};
    free_layouts_.push_back(entry.second);
    return true;
  });
  most_layouts_ = std::max(most_layouts_, 2 * layout_by_radius_.size());
}

/// The box's planes up to the support of the highest sphere near this rank's block. Through a
/// periodic end spheres reach the other side's planes.
template <class Real>
int ImmersedBoundary<Real>::highest_reached_here() const {
  int planes = 0;
  const auto reach = [&](const SphereState& sphere) {
    constexpr double rounding = 1e-6;  // no plane fewer than MarkerHalo finds, which adds otherwise
    const double top = (sphere.position.y() + sphere.radius) / grid_.h + rounding;
    planes = std::max(planes, static_cast<int>(std::floor(top)) + 5);
  };
  for (const SphereState& sphere : fixed_) reach(sphere);
  for (const Mobile& sphere : mobile_) reach(sphere.state);
  return grid_.periodic(1) ? grid_.cells[1] : std::min(planes, grid_.cells[1]);
}

/// Neighbours that a sphere reaches across their common interface (MarkerHalo) both have all planes
/// beside it. The scratch field goes as high.
template <class Real>
void ImmersedBoundary<Real>::find_planes_reached() {
  planes_reached_ =
      std::clamp(highest_reached_here() - decomposition_.first(), 0, decomposition_.planes());
  // Places in a field, as markers keep them.
  mpi_count(scratch_.plane_size() * static_cast<std::uint64_t>(planes_reached_ + 3),
            "velocities beside spheres");
  const int stored = std::max(planes_reached_, 1);
  if (stored <= scratch_.planes()) return;
  scratch_ = Field<Real>(grid_, {1, decomposition_.rows()}, 3);  // its memory first
  scratch_ = Field<Real>(grid_, {stored, decomposition_.rows()}, 3);
}

template <class Real>
void ImmersedBoundary<Real>::place_fixed() {
  double largest = 0.0;
  for (const SphereState& sphere : fixed_) largest = std::max(largest, sphere.radius);
  largest_fixed_ = largest;
  fixed_bins_.emplace(grid_, 2.0 * largest + shared_reach * grid_.h);
  halo_.forget();
  for (std::size_t n = 0; n < fixed_.size(); ++n) {
    fixed_bins_->insert(fixed_[n].position, static_cast<int>(n));
    halo_.mark(fixed_[n].position, fixed_[n].radius);
  }
  halo_.keep();
  fixed_impulse_.assign(fixed_.size(), Vec3::Zero());
  fixed_given_.assign(fixed_.size(), {});
  for (MarkerList<Real>& list : fixed_lists_) list.clear();
  SphereMarkers<Real> markers(grid_);
  for (std::size_t n = 0; n < fixed_.size(); ++n) {
    const SphereState& sphere = fixed_[n];
    std::vector<const SphereState*> overlapping;
    fixed_bins_->near(sphere.position, sphere.radius + largest, [&](int other) {
      const SphereState& candidate = fixed_[static_cast<std::size_t>(other)];
      if (&candidate != &sphere && shortest_way(grid_, sphere.position, candidate.position).norm() <
                                       sphere.radius + candidate.radius)
        overlapping.push_back(&candidate);
    });
    // A marker inside another fixed sphere touches no moving fluid.
    const auto buried = [&](const Vec3& position) {
      return std::any_of(overlapping.begin(), overlapping.end(), [&](const SphereState* other) {
        return shortest_way(grid_, other->position, position).norm() < other->radius - grid_.h;
      });
    };
    const int layout = layout_of(sphere.radius);
    markers.place(sphere.position, layouts_[static_cast<std::size_t>(layout)]);
    for (const std::size_t c : components)
      markers.append(fixed_lists_[c], scratch_, decomposition_, static_cast<int>(c),
                     static_cast<int>(n), layout, buried);
  }
  for (MarkerList<Real>& list : fixed_lists_) {
    list.shrink();
    list.finish();
    if (keeps_force_) list.kept_force.assign(list.volume.size(), Real{});
  }
  weigh_fixed();
}

/// Radius [L].
template <class Real>
double ImmersedBoundary<Real>::largest_mobile() const {
  double largest = 0.0;
  for (const Mobile& sphere : mobile_) largest = std::max(largest, sphere.state.radius);
  return largest;
}

/// Strips along x, so wide that a strip's planes below the spheres that are at work fit into the
/// second-level cache; in bed_10000 widths of 2 to 5 diameters are alike, tags at random in space
/// take 1.3 times as long.
template <class Real>
void ImmersedBoundary<Real>::find_order() {
  constexpr double diameters_in_strip = 3.0;
  const double width = diameters_in_strip * 2.0 * largest_mobile();
  order_.resize(mobile_.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  const auto key = [&](std::size_t n) {
    const SphereState& sphere = mobile_[n].state;
    return std::tuple(std::floor(sphere.position.z() / width), sphere.position.x(), sphere.tag);
  };
  std::sort(order_.begin(), order_.end(),
            [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
}

/// The spheres around each mobile one, images apart from its own ones, with surfaces nearer than
/// `beside`. Of two mobile ones the first has the lower tag.
template <class Real>
void ImmersedBoundary<Real>::find_neighbours() {
  neighbours_.clear();
  first_neighbour_.assign(1, 0);
  const double largest = largest_mobile(), gap = beside * grid_.h;
  SphereBins bins(grid_, 2.0 * largest + gap);
  for (std::size_t n = 0; n < mobile_.size(); ++n)
    bins.insert(mobile_[n].state.position, static_cast<int>(n));
  for (const std::size_t n : order_) {
    const SphereState& sphere = mobile_[n].state;
    const auto note = [&](const SphereState& other, bool first, int index) {
      const double reach = sphere.radius + other.radius + gap;
      const Vec3 nearest = shortest_way(grid_, sphere.position, other.position);
      if (nearest.squaredNorm() >= reach * reach) return;
      each_image(grid_, nearest, reach, [&](const Vec3& way) {
        neighbours_.push_back({way, other.radius, first, !other.mobile, index});
      });
    };
    bins.near(sphere.position, sphere.radius + largest + gap, [&](int other) {
      const auto m = static_cast<std::size_t>(other);
      if (m != n) note(mobile_[m].state, m < n, other);
    });
    if (!fixed_.empty())
      fixed_bins_->near(sphere.position, sphere.radius + largest_fixed_ + gap, [&](int other) {
        note(fixed_[static_cast<std::size_t>(other)], false, other);
      });
    first_neighbour_.push_back(neighbours_.size());
  }
}

/// Finds the mobile spheres' markers and the cells inside. Once a step also their volumes and the
/// points of the layers that go with them (`weighed`): from stage to stage a sphere goes so short a
/// way that both hardly change.
template <class Real>
void ImmersedBoundary<Real>::place_mobile(bool weighed) {
  const Stopwatch watch(seconds_.placing);
  ++placings_;
  halo_.reset();
  mobile_halo_.forget();
  for (MarkerList<Real>& list : mobile_lists_) list.clear();
  interior_.clear();
  dispersion_.clear();
  SphereMarkers<Real> markers(grid_);
  find_order();
  if (weighed) find_neighbours();
  const auto nothing = [](const Vec3&) { return false; };
  for (std::size_t place = 0; place < order_.size(); ++place) {
    const std::size_t n = order_[place];
    const SphereState& sphere = mobile_[n].state;
    halo_.mark(sphere.position, sphere.radius);
    mobile_halo_.mark(sphere.position, sphere.radius);
    const int layout = layout_of(sphere.radius);
    markers.place(sphere.position, layouts_[static_cast<std::size_t>(layout)]);
    for (const std::size_t c : components) {
      markers.append(mobile_lists_[c], scratch_, decomposition_, static_cast<int>(c),
                     static_cast<int>(n), layout, nothing);
      interior_.add(scratch_, grid_, decomposition_, static_cast<int>(c), sphere.position,
                    sphere.radius);
      if (weighed)
        dispersion_.add(grid_, decomposition_, static_cast<int>(c), sphere.position, sphere.radius,
                        neighbours(place));
    }
  }
  halo_.finish();
  mobile_halo_.finish();
  for (MarkerList<Real>& list : mobile_lists_) list.finish();
  use_kept_forces();
  weighed_here_ = weighed;
  if (!weighed) return use_volumes();
  ++weighings_;
  restore_near_mobile();
  if (mobile_.empty()) return;
  weigh_mobile();
  weaken_beside_others();
  share_volumes();
}

/// Indices of all markers of a list.
template <class Real>
std::span<const int> ImmersedBoundary<Real>::all_of(const MarkerList<Real>& list) {
  const auto size = static_cast<std::size_t>(list.size());
  if (indices_.size() < size) {
    indices_.resize(size);
    std::iota(indices_.begin(), indices_.end(), 0);
  }
  return std::span<const int>(indices_).first(size);
}

/// Row sums of the fixed spheres' markers among themselves.
template <class Real>
void ImmersedBoundary<Real>::weigh_fixed() {
  halo_.finish();
  for (const auto& list : fixed_lists_) spread_ones(list, all_of(list), scratch_);
  halo_.collect(scratch_);
  halo_.refresh(scratch_);
  for (const std::size_t c : components) {
    MarkerList<Real>& list = fixed_lists_[c];
    weigh<Real>(list, all_of(list), nullptr, scratch_);
    fixed_row_sums_[c].resize(list.volume.size());
    std::transform(list.volume.begin(), list.volume.end(), fixed_row_sums_[c].begin(),
                   [](Real volume) { return Real{1} / volume; });
  }
  scratch_.fill(Real{});
  for (std::vector<int>& markers : near_mobile_) markers.clear();
  for (std::vector<Real>& kept : kept_beside_mobile_) kept.clear();
}

/// Finds the fixed markers within reach of mobile spheres' markers.
template <class Real>
void ImmersedBoundary<Real>::find_near_mobile() {
  if (fixed_.empty()) return;
  struct Pair {
    int fixed;
    Vec3 way;       ///< from the mobile sphere's centre to the fixed one's
    double radius;  ///< of the mobile sphere
  };
  std::vector<Pair> pairs;
  const double reach = shared_reach * grid_.h, far = pore_to * grid_.h;
  for (std::size_t place = 0; place < order_.size(); ++place)
    for (const SphereNeighbour& other : neighbours(place))
      if (other.fixed)
        pairs.push_back({other.index, other.way, mobile_[order_[place]].state.radius});
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.fixed < b.fixed; });
  Nearest mobile;  // surfaces beside one fixed sphere
  std::array<std::size_t, 3> next{};
  for (std::size_t first = 0; first < pairs.size();) {
    const int sphere = pairs[first].fixed;
    const auto& along = layouts_[static_cast<std::size_t>(
                                     layout_of(fixed_[static_cast<std::size_t>(sphere)].radius))]
                            .along;
    mobile.reset(along[0].size(), far);
    for (; first < pairs.size() && pairs[first].fixed == sphere; ++first)
      mobile.take_sphere(along, pairs[first].way, pairs[first].radius);
    for (const std::size_t c : components) {
      const MarkerList<Real>& list = fixed_lists_[c];
      std::size_t& range = next[c];
      while (range < list.ranges.size() && list.ranges[range].sphere < sphere) ++range;
      if (range == list.ranges.size() || list.ranges[range].sphere != sphere) continue;
      for (int m = list.ranges[range].begin; m < list.ranges[range].end; ++m) {
        const auto offset = static_cast<std::size_t>(list.offset[static_cast<std::size_t>(m)]);
        if (mobile.first[offset] >= reach) continue;
        near_mobile_[c].push_back(m);
        kept_beside_mobile_[c].push_back(static_cast<Real>(volume_beside(
            mobile.first[offset] / grid_.h, mobile.second[offset] / grid_.h, share_at_pores_)));
      }
    }
  }
}

/// Gives the fixed markers that mobile ones were near to the volumes that they have by themselves.
template <class Real>
void ImmersedBoundary<Real>::restore_near_mobile() {
  for (const std::size_t c : components) {
    for (const int m : near_mobile_[c]) {
      const auto n = static_cast<std::size_t>(m);
      fixed_lists_[c].volume[n] = Real{1} / fixed_row_sums_[c][n];
    }
    near_mobile_[c].clear();
    kept_beside_mobile_[c].clear();
  }
}

/// Row sums where mobile markers are: of these, and of the fixed markers around them.
template <class Real>
void ImmersedBoundary<Real>::weigh_mobile() {
  find_near_mobile();

  for (const auto& list : mobile_lists_) spread_ones(list, all_of(list), scratch_);
  mobile_halo_.collect(scratch_);
  mobile_halo_.refresh(scratch_);
  for (const std::size_t c : components)
    weigh(fixed_lists_[c], near_mobile_[c], fixed_row_sums_[c].data(), scratch_);
  mobile_halo_.clear_ghosts(scratch_);
  for (const std::size_t c : components) spread_ones(fixed_lists_[c], near_mobile_[c], scratch_);
  mobile_halo_.collect(scratch_);
  mobile_halo_.refresh(scratch_);
  for (auto& list : mobile_lists_) weigh<Real>(list, all_of(list), nullptr, scratch_);

  for (const std::size_t c : components) clear_supports(fixed_lists_[c], near_mobile_[c], scratch_);
  for (const std::size_t n : order_)
    clear_around(mobile_[n].state, grid_, decomposition_, scratch_);
  mobile_halo_.clear_touched(scratch_);
}

/// Takes from markers what they do not stand for beside the surfaces of other spheres, one of which
/// at least can move, and of mobile spheres beside the box's ends (volume_beside()).
template <class Real>
void ImmersedBoundary<Real>::weaken_beside_others() {
  const double far = pore_to * grid_.h;
  SurfacesBeside surfaces(volume_beside_to * grid_.h, far);
  std::array<std::size_t, 3> next{};  // range of each list
  for (std::size_t place = 0; place < order_.size(); ++place) {
    const SphereState& sphere = mobile_[order_[place]].state;
    std::array<typename MarkerList<Real>::Range, 3> ranges{};
    for (const std::size_t c : components) {
      const auto& of_list = mobile_lists_[c].ranges;
      if (next[c] < of_list.size() && of_list[next[c]].sphere == static_cast<int>(order_[place]))
        ranges[c] = of_list[next[c]++];
    }
    surfaces.begin(sphere);
    for (const BoxEnd& end : ends_) surfaces.add(end);
    each_image(grid_, Vec3::Zero(), 2.0 * sphere.radius + far, [&](const Vec3& way) {
      if (way.norm() > 0.0) surfaces.add_mobile(way, sphere.radius);
    });
    for (const SphereNeighbour& other : neighbours(place)) {
      if (other.fixed)
        surfaces.add_bed(-other.way, other.radius);
      else
        surfaces.add_mobile(-other.way, other.radius);
    }
    if (!surfaces.any()) continue;
    surfaces.measure(layouts_[static_cast<std::size_t>(layout_of(sphere.radius))].along);
    for (const std::size_t c : components) {
      MarkerList<Real>& list = mobile_lists_[c];
      for (auto m = static_cast<std::size_t>(ranges[c].begin);
           m < static_cast<std::size_t>(ranges[c].end); ++m) {
        const auto [film, pore] = surfaces.film_and_pore(static_cast<std::size_t>(list.offset[m]));
        list.volume[m] *=
            static_cast<Real>(volume_beside(film / grid_.h, pore / grid_.h, share_at_pores_));
      }
    }
  }
  for (const std::size_t c : components)
    for (std::size_t m = 0; m < near_mobile_[c].size(); ++m)
      fixed_lists_[c].volume[static_cast<std::size_t>(near_mobile_[c][m])] *=
          kept_beside_mobile_[c][m];
}

template int ImmersedBoundary<float>::highest_reached_here() const;
template void ImmersedBoundary<float>::find_planes_reached();
template void ImmersedBoundary<float>::place_fixed();
template void ImmersedBoundary<float>::place_mobile(bool);
template int ImmersedBoundary<double>::highest_reached_here() const;
template void ImmersedBoundary<double>::find_planes_reached();
template void ImmersedBoundary<double>::place_fixed();
template void ImmersedBoundary<double>::place_mobile(bool);

}  // namespace bedload
