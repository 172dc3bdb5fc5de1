#include "fluid/immersed_boundary/immersed_boundary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>
#include <type_traits>
#include <unordered_set>

#include "fluid/immersed_boundary/gather.hpp"
#include "fluid/immersed_boundary/marker_sweep.hpp"
#include "fluid/immersed_boundary/marker_volume.hpp"
#include "fluid/kernels/fnv.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

/// Markers further than this, in cells, from a sphere share no cells of its markers' supports: two
/// supports of 3 cells, less the markers' retraction. (Cells met only by the corners of both
/// supports count as not shared; their weights are below 1e-3.)
constexpr double shared_reach = 2.5;

constexpr std::array<std::size_t, 3> components{0, 1, 2};

double root_mean(double squares, double count) {
  return count > 0.0 ? std::sqrt(squares / count) : 0.0;
}

/// Adds the time that a scope takes to a sum.
class Stopwatch {
 public:
  explicit Stopwatch(double& sum) : sum_(sum), began_(MPI_Wtime()) {}
  ~Stopwatch() { sum_ += MPI_Wtime() - began_; }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& sum_;
  double began_;
};

[[noreturn]] void report_twins(std::int64_t tag) {
  throw UserError(fmt::format("Two spheres have the tag {}; tags must differ.", tag));
}

void check_tags(std::span<const SphereState> all) {
  std::unordered_set<std::int64_t> tags;
  for (const SphereState& sphere : all)
    if (!tags.insert(sphere.tag).second) report_twins(sphere.tag);
}

void check_radius(const SphereState& sphere) {
  if (!(sphere.radius > 0.0))
    throw UserError(fmt::format("The sphere with tag {} has radius {}; it must be above 0.",
                                sphere.tag, sphere.radius));
}

/// Changes with every fixed sphere and with their order (FNV-1a over tag and numbers).
std::uint64_t fingerprint_with(std::uint64_t hash, const SphereState& s) {
  const auto mix = [&hash](std::uint64_t bits) { hash = fnv_mixed(hash, bits); };
  mix(0x9e3779b97f4a7c15ULL);
  mix(static_cast<std::uint64_t>(s.tag));
  for (const Vec3* v : {&s.position, &s.velocity, &s.angular_velocity})
    for (int d = 0; d < 3; ++d) mix(std::bit_cast<std::uint64_t>((*v)[d]));
  mix(std::bit_cast<std::uint64_t>(s.radius));
  return hash;
}

}  // namespace

template <class Real>
ImmersedBoundary<Real>::ImmersedBoundary(const Settings& settings, const Grid& grid,
                                         const Decomposition& decomposition)
    : grid_(grid),
      decomposition_(decomposition),
      blocks_(block_map(grid, decomposition)),
      density_(settings.fluid.density),
      retraction_(settings.spheres.retraction),
      tolerance_(settings.spheres.slip_tolerance),
      viscosity_(settings.fluid.kinematic_viscosity),
      deferred_impulse_share_(settings.spheres.deferred_impulse_share),
      deferred_angular_share_(settings.spheres.deferred_angular_share),
      gravity_(settings.fluid.gravity[0], settings.fluid.gravity[1], settings.fluid.gravity[2]),
      exchange_(settings.coupling.exchange),
      most_loops_(settings.spheres.forcing_loops),
      halo_(grid_, decomposition),
      mobile_halo_(grid_, decomposition),
      scratch_(grid_, {1, decomposition.rows()}, 3) {}

/// Index of the layout for a radius, made when it is the first of its size.
template <class Real>
int ImmersedBoundary<Real>::layout_of(double radius) {
  const auto [known, is_new] = layout_by_radius_.try_emplace(radius, layouts_.size());
  if (is_new) layouts_.push_back(make_marker_layout(radius, grid_.h, retraction_));
  return static_cast<int>(known->second);
}

template <class Real>
void ImmersedBoundary<Real>::set_spheres(std::span<const SphereState> all) {
  std::vector<SphereState> fixed;
  std::uint64_t fingerprint = 0;
  for (const SphereState& sphere : all) {
    check_radius(sphere);
    if (sphere.mobile) continue;
    fingerprint = fingerprint_with(fingerprint, sphere);
    if (blocks_.is_near(decomposition_.rank(), sphere.position, sphere.radius))
      fixed.push_back(sphere);
  }
  check_tags(all);
  const bool fixed_stay = fingerprint == fixed_fingerprint_;
  fixed_fingerprint_ = fingerprint;
  fixed_ = std::move(fixed);
  set_mobile(all);
  find_planes_reached();
  if (!fixed_stay) place_fixed();
  place_mobile();
}

template <class Real>
void ImmersedBoundary<Real>::move_spheres(std::span<const SphereState> mobile) {
  if (mobile.empty() && mobile_.empty() && decomposition_.ranks() == 1) return;
  const bool stay = set_mobile(mobile);
  if (all_stay(stay)) return;
  find_planes_reached();
  place_mobile();
}

/// Whether the mobile spheres are where their markers are, on every rank: a rank whose spheres stay
/// still has a part in the weights of its neighbours' markers.
template <class Real>
bool ImmersedBoundary<Real>::all_stay(bool here) const {
  int moved = here ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, &moved, 1, MPI_INT, MPI_MAX, decomposition_.comm());
  return moved == 0;
}

/// Keeps the mobile ones among `all` that are near this rank's block. Returns whether these are the
/// same spheres as before in the same places, bit for bit.
template <class Real>
bool ImmersedBoundary<Real>::set_mobile(std::span<const SphereState> all) {
  std::vector<Mobile> now;
  for (const SphereState& sphere : all) {
    if (!sphere.mobile || !blocks_.is_near(decomposition_.rank(), sphere.position, sphere.radius))
      continue;
    check_radius(sphere);
    now.push_back({.state = sphere,
                   .imposed = sphere,
                   .home = blocks_.home(sphere.position),
                   .memory = {},
                   .share = {}});
  }
  std::sort(now.begin(), now.end(),
            [](const Mobile& a, const Mobile& b) { return a.state.tag < b.state.tag; });
  for (std::size_t n = 1; n < now.size(); ++n)
    if (now[n].state.tag == now[n - 1].state.tag) report_twins(now[n].state.tag);
  hand_over_memories(now);
  const bool stay = std::equal(
      now.begin(), now.end(), mobile_.begin(), mobile_.end(), [](const Mobile& a, const Mobile& b) {
        return a.state.tag == b.state.tag && a.state.radius == b.state.radius &&
               a.state.position == b.state.position;
      });
  mobile_ = std::move(now);
  find_partners();
  return stay;
}

/// Up to the highest sphere's support; neighbours that a sphere reaches across their common
/// interface (MarkerHalo) both have all planes beside it. The scratch field goes as high.
template <class Real>
void ImmersedBoundary<Real>::find_planes_reached() {
  int planes = 0;
  const auto reach = [&](const SphereState& sphere) {
    const double top = (sphere.position.y() + sphere.radius) / grid_.h;
    planes = std::max(planes, static_cast<int>(std::floor(top)) + 5 - decomposition_.first());
  };
  for (const SphereState& sphere : fixed_) reach(sphere);
  for (const Mobile& sphere : mobile_) reach(sphere.state);
  // Through a periodic end spheres reach the other side's planes.
  planes_reached_ =
      grid_.periodic(1) ? decomposition_.planes() : std::min(planes, decomposition_.planes());
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
  for (MarkerList<Real>& list : fixed_lists_) list.clear();
  SphereMarkers markers(grid_);
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
  }
  weigh_fixed();
}

template <class Real>
SphereBins ImmersedBoundary<Real>::mobile_bins() {
  largest_mobile_ = 0.0;
  for (const Mobile& sphere : mobile_)
    largest_mobile_ = std::max(largest_mobile_, sphere.state.radius);
  SphereBins bins(grid_, 2.0 * (largest_mobile_ + dispersion_reach * grid_.h));
  for (std::size_t n = 0; n < mobile_.size(); ++n)
    bins.insert(mobile_[n].state.position, static_cast<int>(n));
  return bins;
}

/// The spheres around mobile sphere number `n` that share points of its correction. Points go with
/// a mobile sphere rather than with a fixed one, and with the lower tag.
template <class Real>
void ImmersedBoundary<Real>::find_neighbours(std::size_t n, const SphereBins& mobile) {
  neighbours_.clear();
  const SphereState& sphere = mobile_[n].state;
  const double reach = sphere.radius + 2.0 * dispersion_reach * grid_.h;
  const auto note = [&](const SphereState& other, bool first) {
    each_image(grid_, shortest_way(grid_, sphere.position, other.position), reach + other.radius,
               [&](const Vec3& way) {
                 neighbours_.push_back({way, other.radius, first});
               });
  };
  mobile.near(sphere.position, reach + largest_mobile_, [&](int other) {
    const auto m = static_cast<std::size_t>(other);
    if (m != n) note(mobile_[m].state, m < n);
  });
  if (!fixed_.empty())
    fixed_bins_->near(sphere.position, reach + largest_fixed_,
                      [&](int other) { note(fixed_[static_cast<std::size_t>(other)], false); });
}

template <class Real>
void ImmersedBoundary<Real>::place_mobile() {
  const Stopwatch watch(seconds_.placing);
  ++placings_;
  halo_.reset();
  mobile_halo_.forget();
  for (MarkerList<Real>& list : mobile_lists_) list.clear();
  interior_.clear();
  dispersion_.clear();
  SphereMarkers markers(grid_);
  const SphereBins bins = mobile_bins();
  const auto nothing = [](const Vec3&) { return false; };
  for (std::size_t n = 0; n < mobile_.size(); ++n) {
    const SphereState& sphere = mobile_[n].state;
    halo_.mark(sphere.position, sphere.radius);
    mobile_halo_.mark(sphere.position, sphere.radius);
    const int layout = layout_of(sphere.radius);
    markers.place(sphere.position, layouts_[static_cast<std::size_t>(layout)]);
    find_neighbours(n, bins);
    for (const std::size_t c : components) {
      markers.append(mobile_lists_[c], scratch_, decomposition_, static_cast<int>(c),
                     static_cast<int>(n), layout, nothing);
      interior_.add(scratch_, grid_, decomposition_, static_cast<int>(c), sphere.position,
                    sphere.radius);
      dispersion_.add(grid_, decomposition_, static_cast<int>(c), sphere.position, sphere.radius,
                      neighbours_);
    }
  }
  halo_.finish();
  mobile_halo_.finish();
  for (MarkerList<Real>& list : mobile_lists_) list.finish();
  restore_near_mobile();
  if (!mobile_.empty()) weigh_mobile();
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
}

/// Finds the fixed markers within reach of mobile spheres' markers.
template <class Real>
void ImmersedBoundary<Real>::find_near_mobile() {
  if (fixed_.empty()) return;
  struct Pair {
    int fixed;
    Vec3 way;      ///< from the mobile sphere's centre to the fixed one's
    double reach;  ///< squared, from the mobile sphere's centre
  };
  std::vector<Pair> pairs;
  const double reach = shared_reach * grid_.h;
  for (const Mobile& sphere : mobile_)
    fixed_bins_->near(sphere.state.position, sphere.state.radius + reach + largest_fixed_,
                      [&](int n) {
                        const SphereState& other = fixed_[static_cast<std::size_t>(n)];
                        const Vec3 way = shortest_way(grid_, sphere.state.position, other.position);
                        const double most = sphere.state.radius + reach;
                        each_image(grid_, way, most + other.radius, [&](const Vec3& image) {
                          pairs.push_back({n, image, most * most});
                        });
                      });
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.fixed < b.fixed; });
  std::vector<char> near;  // by offset, of one fixed sphere
  std::array<std::size_t, 3> next{};
  for (std::size_t first = 0; first < pairs.size();) {
    const int sphere = pairs[first].fixed;
    const auto& along = layouts_[static_cast<std::size_t>(
                                     layout_of(fixed_[static_cast<std::size_t>(sphere)].radius))]
                            .along;
    near.assign(along[0].size(), 0);
    for (; first < pairs.size() && pairs[first].fixed == sphere; ++first) {
      const Pair& pair = pairs[first];
      for (std::size_t m = 0; m < near.size(); ++m) {
        const double x = pair.way.x() + along[0][m], y = pair.way.y() + along[1][m],
                     z = pair.way.z() + along[2][m];
        near[m] |= static_cast<char>(x * x + y * y + z * z < pair.reach);
      }
    }
    for (const std::size_t c : components) {
      const MarkerList<Real>& list = fixed_lists_[c];
      std::size_t& range = next[c];
      while (range < list.ranges.size() && list.ranges[range].sphere < sphere) ++range;
      if (range == list.ranges.size() || list.ranges[range].sphere != sphere) continue;
      for (int m = list.ranges[range].begin; m < list.ranges[range].end; ++m)
        if (near[static_cast<std::size_t>(list.offset[static_cast<std::size_t>(m)])])
          near_mobile_[c].push_back(m);
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
  for (const Mobile& sphere : mobile_) clear_around(sphere.state, grid_, decomposition_, scratch_);
  mobile_halo_.clear_touched(scratch_);
}

template <class Real>
void ImmersedBoundary<Real>::start_stage(const Field<Real>& velocity) {
  const Stopwatch watch(seconds_.interior);
  for (std::size_t n = 0; n < mobile_.size(); ++n)
    for (const std::size_t c : components)
      mobile_[n].share.before[c] = interior_.sums(3 * n + c, velocity);
  stage_started_ = true;
}

/// This rank's share of the slip; calls use(is fixed, component, marker, slip) for each marker.
template <class Real>
template <class Use>
typename ImmersedBoundary<Real>::SlipSums ImmersedBoundary<Real>::local_slip(
    const Field<Real>& velocity, Use use) const {
  SlipSums sums;
  const auto fixed = [this](int n) -> const SphereState& {
    return fixed_[static_cast<std::size_t>(n)];
  };
  const auto mobile = [this](int n) -> const SphereState& {
    return mobile_[static_cast<std::size_t>(n)].imposed;
  };
  for (const std::size_t c : components) {
    const int component = static_cast<int>(c);
    const auto use_fixed = [&](std::size_t m, Real slip) { use(true, c, m, slip); };
    const auto use_mobile = [&](std::size_t m, Real slip) { use(false, c, m, slip); };
    sums.max = std::max(
        {sums.max,
         for_slips(fixed_lists_[c], velocity, component, fixed, layouts_, sums.squares, use_fixed),
         for_slips(mobile_lists_[c], velocity, component, mobile, layouts_, sums.squares,
                   use_mobile)});
    sums.markers += (fixed_lists_[c].size() + mobile_lists_[c].size()) / 3.0;
  }
  return sums;
}

/// increment_l = V_l (U_l - (J u)_l) for all markers.
template <class Real>
typename ImmersedBoundary<Real>::SlipSums ImmersedBoundary<Real>::find_increments(
    const Field<Real>& velocity) {
  return local_slip(velocity, [this](bool is_fixed, std::size_t c, std::size_t m, Real slip) {
    MarkerList<Real>& list = is_fixed ? fixed_lists_[c] : mobile_lists_[c];
    list.increment[m] = list.volume[m] * slip;
  });
}

template <class Real>
Slip ImmersedBoundary<Real>::slip(const Field<Real>& velocity) const {
  SlipSums sums = local_slip(velocity, [](bool, std::size_t, std::size_t, Real) {});
  std::array<double, 2> added{sums.squares, sums.markers};
  MPI_Allreduce(MPI_IN_PLACE, &sums.max, 1, MPI_DOUBLE, MPI_MAX, decomposition_.comm());
  MPI_Allreduce(MPI_IN_PLACE, added.data(), 2, MPI_DOUBLE, MPI_SUM, decomposition_.comm());
  return {.max = sums.max, .rms = root_mean(added[0], added[1])};
}

template <class Real>
void ImmersedBoundary<Real>::force(Field<Real>& velocity, double stage_step, double step,
                                   bool measure) {
  assert(mobile_.empty() || stage_started_);
  stage_started_ = false;
  share_excess_spins();
  double loop_began = MPI_Wtime();
  const auto end_loop = [&](double& sum) {
    const double now = MPI_Wtime();
    sum += now - loop_began;
    loop_began = now;
  };
  int loops = 0;
  halo_.refresh(velocity);
  correct_dispersion(velocity, stage_step, step);
  SlipSums before = find_increments(velocity), after = before;
  while (true) {
    halo_.clear_ghosts(velocity);
    for (Lists* lists : {&fixed_lists_, &mobile_lists_})
      for (MarkerList<Real>& list : *lists) spread_increments(list, velocity, loops == 0);
    halo_.collect(velocity);
    halo_.refresh(velocity);
    end_loop(loops == 0 ? seconds_.first_loops : seconds_.extra_loops);
    ++loops;
    if (loops == most_loops_ && !measure) break;
    after = find_increments(velocity);
    if (loops == most_loops_ || within_tolerance(after.max)) break;
  }
  applied_ = {.loops = loops, .before = before, .after = after};
  sum_applied(stage_step);
  end_loop(loops == 1 ? seconds_.first_loops : seconds_.extra_loops);

  for (std::size_t n = 0; n < mobile_.size(); ++n)
    for (const std::size_t c : components)
      mobile_[n].share.after[c] = interior_.sums(3 * n + c, velocity);
  end_loop(seconds_.interior);
}

/// Ghosts near the spheres are valid before and after.
template <class Real>
void ImmersedBoundary<Real>::correct_dispersion(Field<Real>& velocity, double stage_step,
                                                double step) {
  for (std::size_t n = 0; n < mobile_.size(); ++n) {
    const SphereState& sphere = mobile_[n].state;
    const double time = dispersion_share(sphere, grid_.h, step) * stage_step;
    mobile_[n].carried_moment = dispersion_.find(n, sphere, grid_, time, velocity, scratch_);
  }
  mobile_halo_.collect(scratch_);
  mobile_halo_.clear_ghosts(scratch_);
  for (const Mobile& sphere : mobile_)
    DispersionCorrection<Real>::give(sphere.state.position, sphere.state.radius, grid_,
                                     decomposition_, scratch_, velocity);
  mobile_halo_.refresh(velocity);
}

template <class Real>
bool ImmersedBoundary<Real>::within_tolerance(double local_max) const {
  if (tolerance_ <= 0.0) return false;
  MPI_Allreduce(MPI_IN_PLACE, &local_max, 1, MPI_DOUBLE, MPI_MAX, decomposition_.comm());
  return local_max <= tolerance_;
}

/// Sums what this rank's markers gave, per mobile sphere and in all.
template <class Real>
void ImmersedBoundary<Real>::sum_applied(double stage_step) {
  for (Mobile& sphere : mobile_) {
    sphere.share.applied = {};
    std::copy_n(sphere.carried_moment.data(), 3, sphere.share.applied_moment.begin());
  }
  const double to_force = density_ * grid_.cell_volume() / stage_step;
  for (int c = 0; c < 3; ++c) {
    const auto component = static_cast<std::size_t>(c);
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    const auto moment_about = [](int d) { return static_cast<std::size_t>(d); };
    double by_fixed = 0.0, by_mobile = 0.0;
    for (const auto& range : fixed_lists_[component].ranges) {
      double sum = 0.0;
      for (int m = range.begin; m < range.end; ++m)
        sum += static_cast<double>(fixed_lists_[component].applied[static_cast<std::size_t>(m)]);
      fixed_impulse_[static_cast<std::size_t>(range.sphere)][c] += to_force * stage_step * sum;
      by_fixed += sum;
    }
    const MarkerList<Real>& list = mobile_lists_[component];
    for (const auto& range : list.ranges) {
      Share& share = mobile_[static_cast<std::size_t>(range.sphere)].share;
      const MarkerLayout& layout = layouts_[static_cast<std::size_t>(range.layout)];
      double sum = 0.0, moment_a = 0.0, moment_b = 0.0;
      for (auto m = static_cast<std::size_t>(range.begin); m < static_cast<std::size_t>(range.end);
           ++m) {
        const double applied = static_cast<double>(list.applied[m]);
        const Vec3& offset = layout.offsets[static_cast<std::size_t>(list.offset[m])];
        sum += applied;
        moment_a += offset[b] * applied;  // (r cross f)_a = r_b f_c - r_c f_b
        moment_b -= offset[a] * applied;  // (r cross f)_b = r_c f_a - r_a f_c
      }
      share.applied[component] += sum;
      share.applied_moment[moment_about(a)] += moment_a;
      share.applied_moment[moment_about(b)] += moment_b;
      by_mobile += sum;
    }
    applied_.by_fixed[c] = to_force * by_fixed;
    applied_.by_mobile[c] = to_force * by_mobile;
  }
}

template <class Real>
std::vector<SphereLoad> ImmersedBoundary<Real>::take_fixed_impulses() {
  std::vector<SphereLoad> impulses;
  for (std::size_t n = 0; n < fixed_.size(); ++n)
    impulses.push_back({.tag = fixed_[n].tag, .force = fixed_impulse_[n]});
  fixed_impulse_.assign(fixed_.size(), Vec3::Zero());
  return impulses;
}

template <class Real>
ForcingReport ImmersedBoundary<Real>::report() const {
  const Vec3 all = applied_.by_mobile + applied_.by_fixed, &fixed = applied_.by_fixed;
  std::array<double, 9> total{all[0],
                              all[1],
                              all[2],
                              fixed[0],
                              fixed[1],
                              fixed[2],
                              applied_.before.squares,
                              applied_.after.squares,
                              applied_.before.markers};
  std::array<double, 2> largest{applied_.before.max, applied_.after.max};
  MPI_Allreduce(MPI_IN_PLACE, total.data(), 9, MPI_DOUBLE, MPI_SUM, decomposition_.comm());
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 2, MPI_DOUBLE, MPI_MAX, decomposition_.comm());
  return {.loops = applied_.loops,
          .before = {.max = largest[0], .rms = root_mean(total[6], total[8])},
          .after = {.max = largest[1], .rms = root_mean(total[7], total[8])},
          .force_on_fluid = Vec3(total[0], total[1], total[2]),
          .force_of_fixed = Vec3(total[3], total[4], total[5])};
}

template class ImmersedBoundary<float>;
template class ImmersedBoundary<double>;

}  // namespace bedload
