#include "fluid/immersed_boundary/immersed_boundary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <unordered_set>

#include "fluid/grid/diffusion_limit.hpp"
#include "fluid/immersed_boundary/marker_volume.hpp"
#include "fluid/immersed_boundary/stopwatch.hpp"
#include "fluid/kernels/fnv.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

constexpr std::array<std::size_t, 3> components{0, 1, 2};

double root_mean(double squares, double count) {
  return count > 0.0 ? std::sqrt(squares / count) : 0.0;
}

[[noreturn]] void report_twins(std::int64_t tag) {
  throw UserError(fmt::format("Two spheres have the tag {}; tags must differ.", tag));
}

void check_tags(std::span<const SphereState> spheres) {
  std::unordered_set<std::int64_t> tags;
  for (const SphereState& sphere : spheres)
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
      marker_density_(settings.spheres.marker_density),
      tolerance_(settings.spheres.slip_tolerance),
      viscosity_(settings.fluid.kinematic_viscosity),
      deferred_impulse_share_(settings.spheres.deferred_impulse_share),
      deferred_angular_share_(settings.spheres.deferred_angular_share),
      pressure_share_(settings.spheres.pressure_share),
      gravity_(settings.spheres.buoyancy ? Vec3(settings.fluid.gravity.data()) : Vec3::Zero()),
      exchange_(settings.coupling.exchange),
      most_loops_(settings.spheres.forcing_loops),
      interior_term_(settings.spheres.interior_term),
      rigid_core_(settings.spheres.rigid_core),
      keeps_force_(diffusion_is_implicit(settings, grid)),
      halo_(grid_, decomposition),
      mobile_halo_(grid_, decomposition),
      scratch_(grid_, {1, decomposition.rows()}, 3),
      share_at_pores_(share_in_steps_of(settings.time.step)) {
  const std::array ends{settings.boundary.x, settings.boundary.y, settings.boundary.z};
  for (std::size_t d = 0; d < ends.size(); ++d)
    for (const std::size_t end : {0, 1})
      if (ends[d][end] != Wall::periodic)
        ends_.push_back({static_cast<int>(d), end == 0 ? 1.0 : -1.0,
                         end == 0 ? 0.0 : grid.length[d], ends[d][end] == Wall::free_slip});
}

template <class Real>
void ImmersedBoundary<Real>::set_spheres(std::span<const SphereState> spheres) {
  std::vector<SphereState> fixed;
  std::uint64_t fingerprint = 0;
  for (const SphereState& sphere : spheres) {
    check_radius(sphere);
    if (sphere.mobile) continue;
    if (!blocks_.is_near(decomposition_.rank(), sphere.position, sphere.radius)) continue;
    fingerprint = fingerprint_with(fingerprint, sphere);
    fixed.push_back(sphere);
  }
  check_tags(spheres);
  const Change of_fixed = fingerprint == fixed_fingerprint_ ? Change::none : Change::weigh;
  fixed_fingerprint_ = fingerprint;
  fixed_ = std::move(fixed);
  set_mobile(spheres);
  // Where some are others, all ranks weigh: neighbours' markers have a part in the weights.
  const bool fixed_stay = most_of_all(of_fixed) == Change::none;
  find_planes_reached();
  if (!fixed_stay) place_fixed();
  place_mobile(true);
}

template <class Real>
void ImmersedBoundary<Real>::move_spheres(std::span<const SphereState> mobile, double time_step,
                                          bool begins_step) {
  if (mobile.empty() && mobile_.empty() && decomposition_.ranks() == 1) return;
  const auto [moved, remade] = set_mobile(mobile);
  const double share = share_in_steps_of(time_step);
  const bool stale = moved || !weighed_here_ || share != share_at_pores_;
  const Change change = most_of_all(remade || (begins_step && stale) ? Change::weigh
                                    : moved                          ? Change::place
                                                                     : Change::none);
  if (change == Change::weigh) share_at_pores_ = share;
  if (change == Change::none) return;
  find_planes_reached();
  place_mobile(change == Change::weigh);
}

/// What is to be done on every rank: one whose spheres stay still has a part in the weights of its
/// neighbours' markers. Notes how high spheres reach on any, how light the lightest mobile one is,
/// and whether there are several.
template <class Real>
typename ImmersedBoundary<Real>::Change ImmersedBoundary<Real>::most_of_all(Change here) {
  constexpr double none = std::numeric_limits<double>::infinity();
  double lightest = none, first_tag = none, last_tag = -none;
  for (const Mobile& sphere : mobile_) {
    if (sphere.state.density > 0.0) lightest = std::min(lightest, sphere.state.density);
    first_tag = std::min(first_tag, static_cast<double>(sphere.state.tag));
    last_tag = std::max(last_tag, static_cast<double>(sphere.state.tag));
  }
  std::array<double, 5> most{static_cast<double>(here), static_cast<double>(highest_reached_here()),
                             -lightest, -first_tag, last_tag};
  MPI_Allreduce(MPI_IN_PLACE, most.data(), 5, MPI_DOUBLE, MPI_MAX, decomposition_.comm());
  highest_reached_ = static_cast<int>(most[1]);
  lightest_density_ = -most[2] == none ? 0.0 : -most[2];
  several_mobile_ = -most[3] < most[4];
  return static_cast<Change>(static_cast<int>(most[0]));
}

/// Of markers at pores, the volume that they keep.
template <class Real>
double ImmersedBoundary<Real>::share_in_steps_of(double time_step) const {
  return share_at_pores(viscosity_ * time_step / (grid_.h * grid_.h), most_loops_);
}

/// Keeps the mobile ones among `all` that are near this rank's block.
template <class Real>
typename ImmersedBoundary<Real>::Changes ImmersedBoundary<Real>::set_mobile(
    std::span<const SphereState> all) {
  std::vector<Mobile> now;
  for (const SphereState& sphere : all) {
    if (!sphere.mobile || !blocks_.is_near(decomposition_.rank(), sphere.position, sphere.radius))
      continue;
    check_radius(sphere);
    now.push_back({.state = sphere,
                   .imposed = sphere,
                   .home = blocks_.home(sphere.position),
                   .memory = {},
                   .volumes = {},
                   .kept_forces = {},
                   .share = {}});
  }
  std::sort(now.begin(), now.end(),
            [](const Mobile& a, const Mobile& b) { return a.state.tag < b.state.tag; });
  for (std::size_t n = 1; n < now.size(); ++n)
    if (now[n].state.tag == now[n - 1].state.tag) report_twins(now[n].state.tag);
  hand_over_memories(now);
  const bool moved = !std::equal(
      now.begin(), now.end(), mobile_.begin(), mobile_.end(), [](const Mobile& a, const Mobile& b) {
        return a.state.tag == b.state.tag && !a.state.is_new && a.state.radius == b.state.radius &&
               a.state.position == b.state.position;
      });
  const bool remade = keep_by_marker(now);
  mobile_ = std::move(now);
  find_partners();
  return {.moved = moved, .remade = remade};
}

template <class Real>
void ImmersedBoundary<Real>::start_stage(const Field<Real>& velocity) {
  const Stopwatch watch(seconds_.interior);
  for (std::size_t place = 0; interior_term_ && place < order_.size(); ++place)
    for (const std::size_t c : components)
      mobile_[order_[place]].share.before[c] = interior_.sums(3 * place + c, velocity);
  stage_started_ = true;
}

/// This rank's share of the slip; calls use(is fixed, component, marker, slip) for each marker.
template <class Real>
template <class Use>
SlipSums ImmersedBoundary<Real>::local_slip(const Field<Real>& velocity, Use use) const {
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
    for_slips(fixed_lists_[c], velocity, component, fixed, layouts_, sums, use_fixed);
    for_slips(mobile_lists_[c], velocity, component, mobile, layouts_, sums, use_mobile);
  }
  return sums;
}

/// increment_l = V_l (U_l - (J u)_l) for all markers.
template <class Real>
SlipSums ImmersedBoundary<Real>::find_increments(const Field<Real>& velocity) {
  return local_slip(velocity, [this](bool is_fixed, std::size_t c, std::size_t m, Real slip) {
    MarkerList<Real>& list = is_fixed ? fixed_lists_[c] : mobile_lists_[c];
    list.increment[m] = list.volume[m] * slip;
  });
}

/// u += J^T increment for all markers.
template <class Real>
void ImmersedBoundary<Real>::spread_all(Field<Real>& velocity) {
  const auto to_fixed = [this](int n) -> FluidChange& {
    return fixed_given_[static_cast<std::size_t>(n)];
  };
  const auto to_mobile = [this](int n) -> FluidChange& {
    return mobile_[static_cast<std::size_t>(n)].given;
  };
  for (const std::size_t c : components) {
    const int component = static_cast<int>(c);
    spread_increments(fixed_lists_[c], velocity, component, to_fixed, layouts_);
    spread_increments(mobile_lists_[c], velocity, component, to_mobile, layouts_);
  }
}

template <class Real>
Slip ImmersedBoundary<Real>::slip(const Field<Real>& velocity) const {
  SlipSums sums = local_slip(velocity, [](bool, std::size_t, std::size_t, Real) {});
  std::array<double, 2> added{sums.squares, static_cast<double>(sums.components) / 3.0};
  MPI_Allreduce(MPI_IN_PLACE, &sums.max, 1, MPI_DOUBLE, MPI_MAX, decomposition_.comm());
  MPI_Allreduce(MPI_IN_PLACE, added.data(), 2, MPI_DOUBLE, MPI_SUM, decomposition_.comm());
  return {.max = sums.max, .rms = root_mean(added[0], added[1])};
}

template <class Real>
void ImmersedBoundary<Real>::force(Field<Real>& velocity, double stage_step, double carry_time,
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
  carry_cores(velocity);
  halo_.refresh(velocity);
  correct_dispersion(velocity, carry_time);
  SlipSums before = find_increments(velocity), after = before;
  while (true) {
    halo_.clear_ghosts(velocity);
    spread_all(velocity);
    if (keeps_force_) keep_increments();
    halo_.collect(velocity);
    halo_.refresh(velocity);
    end_loop(loops == 0 ? seconds_.first_loops : seconds_.extra_loops);
    ++loops;
    if (loops == most_loops_ && !measure) break;
    after = find_increments(velocity);
    if (loops == most_loops_ || within_tolerance(after.within_reach)) break;
  }
  applied_ = {.loops = loops, .before = before, .after = after};
  sum_applied(stage_step);
  if (keeps_force_) share_kept_forces();
  end_loop(loops == 1 ? seconds_.first_loops : seconds_.extra_loops);

  for (std::size_t place = 0; interior_term_ && place < order_.size(); ++place)
    for (const std::size_t c : components)
      mobile_[order_[place]].share.after[c] = interior_.sums(3 * place + c, velocity);
  end_loop(seconds_.interior);
}

/// Ghosts near the spheres are left as they were.
template <class Real>
void ImmersedBoundary<Real>::carry_cores(Field<Real>& velocity) {
  const auto carry = [&](const SphereState& sphere, FluidChange& given) {
    if (const double radius = core_of(sphere.radius); radius > 0.0)
      given += carry_core(velocity, grid_, decomposition_, sphere, radius);
  };
  for (std::size_t n = 0; n < fixed_.size(); ++n) carry(fixed_[n], fixed_given_[n]);
  for (const std::size_t n : order_) carry(mobile_[n].state, mobile_[n].given);
}

/// Ghosts near the spheres are valid before and after.
template <class Real>
void ImmersedBoundary<Real>::correct_dispersion(Field<Real>& velocity, double carry_time) {
  if (carry_time == 0.0) return;
  assert(weighed_here_);  // the layers' points are found together with the markers' volumes
  for (std::size_t place = 0; place < order_.size(); ++place) {
    Mobile& sphere = mobile_[order_[place]];
    const double time = dispersion_share(sphere.state, grid_.h, carry_time) * carry_time;
    sphere.given.angular += dispersion_.find(place, sphere.state, grid_, time, velocity, scratch_);
  }
  mobile_halo_.collect(scratch_);
  mobile_halo_.clear_ghosts(scratch_);
  for (const std::size_t n : order_)
    dispersion_.mark(mobile_[n].state.position, mobile_[n].state.radius, grid_, decomposition_);
  dispersion_.give(scratch_, velocity);
  mobile_halo_.refresh(velocity);
}

template <class Real>
bool ImmersedBoundary<Real>::within_tolerance(double local_max) const {
  if (tolerance_ <= 0.0) return false;
  MPI_Allreduce(MPI_IN_PLACE, &local_max, 1, MPI_DOUBLE, MPI_MAX, decomposition_.comm());
  return local_max <= tolerance_;
}

/// Sums what this rank's fluid got, per sphere and in all; the next stage begins at zero.
template <class Real>
void ImmersedBoundary<Real>::sum_applied(double stage_step) {
  const double to_impulse = density_ * grid_.cell_volume();
  for (std::size_t n = 0; n < fixed_.size(); ++n) {
    const Vec3 impulse = to_impulse * fixed_given_[n].linear;
    fixed_impulse_[n] += impulse;
    applied_.by_fixed += impulse / stage_step;
  }
  fixed_given_.assign(fixed_.size(), {});
  for (Mobile& sphere : mobile_) {
    std::copy_n(sphere.given.linear.data(), 3, sphere.share.applied.begin());
    std::copy_n(sphere.given.angular.data(), 3, sphere.share.applied_moment.begin());
    applied_.by_mobile += to_impulse / stage_step * sphere.given.linear;
    sphere.given = {};
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
                              static_cast<double>(applied_.before.components) / 3.0};
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
