#include "coupling/bedload_fluid/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <numbers>

#include "coupling/exchange/stages.hpp"
#include "fluid/channel/runge_kutta.hpp"
#include "fluid/grid/at_end_of_stage.hpp"
#include "fluid/grid/block_map.hpp"
#include "fluid/grid/diffusion_limit.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/statistics/sphere_layer.hpp"
#include "fluid/validation/validate.hpp"

namespace bedload {

static_assert(DemSteps{}.in_stage.size() == stage_count);

template <class Real>
Simulation<Real>::Phases::Phases(Timing& timing, bool spheres, bool coupled) {
  if (spheres) {
    predictor = timing.add_phase("fluid predictor");
    markers = timing.add_phase("markers");
    if (coupled) exchange = timing.add_phase("exchange");
    pressure = timing.add_phase("pressure");
    if (coupled) waiting = timing.add_phase("waiting for LIGGGHTS");
  } else {
    flow = timing.add_phase("predictor and pressure");
  }
  closing = timing.add_phase("end of the step");
}

template <class Real>
Simulation<Real>::Simulation(const Settings& settings, MPI_Comm comm, FluidSide* partner,
                             std::span<const SphereState> spheres, const Cuts& cuts)
    : channel_(settings, comm, at_end_of_stage(make_grid(settings), spheres, 0.0), cuts),
      partner_(partner),
      phases_(timing_, partner != nullptr || channel_.immersed_boundary() != nullptr,
              partner != nullptr),
      changes_(channel_.grid()) {
  const BlockMap blocks = block_map(channel_.grid(), channel_.decomposition());
  for (const SphereState& s : spheres)
    if (s.mobile || blocks.is_near(channel_.decomposition().rank(), s.position, s.radius))
      spheres_.push_back(s);
  changes_.update(spheres_);
  count_spheres();
  if (settings.output.energy_work)
    energy_ = std::make_unique<EnergyAccount<Real>>(channel_.grid(), channel_.decomposition());
  if (partner_) partner_->divide(blocks);
}

template <class Real>
void Simulation<Real>::count_spheres() {
  const std::vector<SphereState> mobile = mobile_here(), fixed = fixed_here();
  Vec3 buoyancy_here = Vec3::Zero();
  for (const SphereState& sphere : fixed) buoyancy_here += buoyancy(sphere);
  std::array<double, 6> sums{static_cast<double>(mobile.size()),
                             kinds_of(mobile),
                             static_cast<double>(fixed.size()),
                             buoyancy_here[0],
                             buoyancy_here[1],
                             buoyancy_here[2]};
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                channel_.comm());
  account_.mobile = static_cast<std::int64_t>(sums[0]);
  account_.kinds = sums[1];
  has_fixed_ = sums[2] > 0.0;
  may_have_spheres_ = partner_ != nullptr || has_fixed_;
  buoyancy_of_fixed_ = Vec3(&sums[3]);
}

// The Runge-Kutta stages of one step. While the pressure is solved, which needs nothing of the
// grains, LIGGGHTS moves them by the loads of the same stage, in 8, 2 and 5 steps of its own. With
// one exchange per step they stand still until the last stage, and then move by the mean of the
// loads.
template <class Real>
void Simulation<Real>::make_step(bool last) {
  begin_step();
  renew_spheres();
  for (int stage = 0; stage < stage_count; ++stage) {
    if (energy_) energy_->begin_stage(channel_.velocity(), stage);
    if (!channel_.immersed_boundary() && !partner_) {
      timing_.measure(phases_.flow, [&] {
        channel_.predict(stage);
        channel_.project(stage);
      });
      end_stage(stage);
      continue;
    }
    timing_.measure(phases_.predictor, [&] { channel_.predict(stage); });
    if (energy_) energy_->predicted(channel_.velocity());
    loads_ = timing_.measure(phases_.markers, [&] { return channel_.force_spheres(stage); });
    if (energy_) energy_->forced(channel_.velocity());
    check_loads();
    add_to_mean(stage);
    const bool exchange = partner_ && partner_->dem_steps().exchange_in(stage);
    if (exchange)
      timing_.measure(phases_.exchange, [&] {
        partner_->send_loads(stage, channel_.time_step(), last, loads_to_send());
      });
    timing_.measure(phases_.pressure, [&] { channel_.project(stage); });
    end_stage(stage);
    if (!exchange) continue;
    motion_ = timing_.measure(phases_.waiting, [&] { return partner_->receive_motion(); });
    timing_.measure(phases_.markers, [&] { move_spheres(channel_.time_step()); });
    take_note();
  }
  timing_.measure(phases_.closing, [&] {
    channel_.finish_step();
    if (auto* boundary = channel_.immersed_boundary())
      fixed_impulses_ = boundary->take_fixed_impulses();
    if (partner_) {
      const double kinds = account_.kinds;
      account_ = partner_->settle();
      spheres_changed_ = account_.kinds != kinds;
    }
  });
  check_momentum();
}

template <class Real>
void Simulation<Real>::renew_spheres() {
  if (!partner_ || !partner_->renewal_due()) return;
  motion_.mobile = timing_.measure(phases_.waiting, [&] { return partner_->receive_renewed(); });
  timing_.measure(phases_.markers, [&] { move_spheres(channel_.last_time_step()); });
}

template <class Real>
void Simulation<Real>::place_for_first_stage() {
  if (!partner_) return;
  std::ranges::copy_if(spheres_, std::back_inserter(motion_.mobile), &SphereState::mobile);
  place_spheres(channel_.step() > 0 ? channel_.last_time_step() : channel_.time_step());
}

template <class Real>
void Simulation<Real>::begin_step() {
  mean_loads_.clear();
  grain_intervals_.clear();
}

template <class Real>
void Simulation<Real>::end_stage(int stage) {
  if (!energy_) return;
  const Settings& s = channel_.settings();
  energy_->end_stage(channel_.velocity(), stage, channel_.time_step(), s.fluid,
                     diffusion_is_implicit(s, channel_.grid()));
}

template <class Real>
void Simulation<Real>::move_spheres(double dt) {
  std::erase_if(spheres_, [](const SphereState& s) { return s.mobile; });
  spheres_.insert(spheres_.end(), motion_.mobile.begin(), motion_.mobile.end());
  const std::vector<std::int64_t> changed = changes_.update(motion_.mobile);
  try {
    validate(channel_.settings(), spheres_, changed);
  } catch (const UserError& error) {
    throw UserError(fmt::format("step {}: of spheres that came or changed, {}", channel_.step() + 1,
                                error.what()));
  }
  place_spheres(dt);
}

/// For the coming stage. `dt` is the step that was made last, which a restart knows (before the
/// first one, that to come); with time.cfl the coming one may be another.
template <class Real>
void Simulation<Real>::place_spheres(double dt) {
  const double stage = runge_kutta[static_cast<std::size_t>(channel_.next_stage())].two_alpha * dt;
  channel_.move_spheres(at_end_of_stage(channel_.grid(), motion_.mobile, stage), dt);
}

/// LIGGGHTS never hears of a load that is no number.
template <class Real>
void Simulation<Real>::check_loads() const {
  for (const SphereLoad& load : loads_) {
    if (load.force.allFinite() && load.torque.allFinite()) continue;
    const auto sphere = std::find_if(spheres_.begin(), spheres_.end(),
                                     [&](const SphereState& s) { return s.tag == load.tag; });
    const Vec3 cell = sphere->position / channel_.grid().h;
    throw UserError(fmt::format(
        "{}: after step {} (t = {:.6g}): the fluid's load on sphere {} near cell ({:.0f}, {:.0f}, "
        "{:.0f}) is not finite; reduce 'time.step' ({}).",
        channel_.settings().file, channel_.step(), channel_.time(), load.tag, std::floor(cell[0]),
        std::floor(cell[1]), std::floor(cell[2]), channel_.time_step()));
  }
}

/// Results cannot be trusted when momentum was lost between the programs, or in the
/// fluid.
template <class Real>
void Simulation<Real>::check_momentum() const {
  constexpr double most_given = 1e-6;  // round-off
  const bool in_exchange = account_.momentum_residual > most_given;
  const double most = in_exchange ? most_given : channel_.momentum_rounding();
  const double residual =
      in_exchange ? account_.momentum_residual : std::abs(channel_.momentum_residual());
  if (!(residual > most)) return;  // not followed: NaN
  throw UserError(fmt::format(
      "{}: step {} (t = {:.6g}): momentum is not balanced: what {} differs by {:.3g} of its size, "
      "and at most {:.0e} is round-off. A fix of the LIGGGHTS script that changes the time step, "
      "the forces or the spheres behind 'fix couple/fluid' can be the cause.",
      channel_.settings().file, channel_.step(), channel_.time(),
      in_exchange ? "the fluid gave to the spheres and what they got"
                  : "the flow gained and what drives it and holds it back",
      residual, most));
}

// mean of F over the step = sum over the stages of 2 alpha_k F_k
template <class Real>
void Simulation<Real>::add_to_mean(int stage) {
  const double weight = runge_kutta[static_cast<std::size_t>(stage)].two_alpha;
  for (const SphereLoad& load : loads_) {
    SphereLoad& mean = mean_loads_.try_emplace(load.tag, SphereLoad{load.tag}).first->second;
    mean.force += weight * load.force;
    mean.torque += weight * load.torque;
  }
}

// A sphere that waits for the last stage stays on its rank, so that all its stages are here.
template <class Real>
std::vector<SphereLoad> Simulation<Real>::loads_to_send() const {
  return partner_->dem_steps().exchange_in(0) ? loads_ : mean_loads();
}

template <class Real>
void Simulation<Real>::take_note() {
  grain_intervals_.push_back({motion_.dem_began, motion_.dem_ended});
  grain_seconds_ += motion_.dem_ended - motion_.dem_began;
}

template <class Real>
std::vector<SphereState> Simulation<Real>::here(bool mobile) const {
  const BlockMap blocks = block_map(channel_.grid(), channel_.decomposition());
  std::vector<SphereState> here;
  for (const SphereState& s : spheres_)
    if (s.mobile == mobile && blocks.home(s.position) == channel_.decomposition().rank())
      here.push_back(s);
  return here;
}

template <class Real>
SphereExtremes Simulation<Real>::extremes() const {
  const SphereExtremes mine = extremes_of(channel_.settings(), mobile_here(), channel_.time_step());
  std::array<double, 10> least{mine.lightest, -mine.heaviest,          mine.thinnest_layer,
                               -mine.fastest, -mine.fastest_light,     mine.lightest_ratio,
                               -mine.widest,  mine.weigh ? -1.0 : 0.0, -mine.heaviest_ratio,
                               mine.narrowest};
  MPI_Allreduce(MPI_IN_PLACE, least.data(), static_cast<int>(least.size()), MPI_DOUBLE, MPI_MIN,
                channel_.comm());
  double reynolds = mine.thinnest_layer == least[2] ? mine.reynolds : 0.0;
  MPI_Allreduce(MPI_IN_PLACE, &reynolds, 1, MPI_DOUBLE, MPI_MAX, channel_.comm());
  return {.lightest = least[0],
          .heaviest = -least[1],
          .thinnest_layer = least[2],
          .reynolds = reynolds,
          .fastest = -least[3],
          .fastest_light = -least[4],
          .lightest_ratio = least[5],
          .weigh = least[7] < 0.0,
          .heaviest_ratio = -least[8],
          .widest = -least[6],
          .narrowest = least[9],
          .time_step = mine.time_step,
          .held = has_fixed_};
}

template <class Real>
std::vector<SphereLoad> Simulation<Real>::mean_loads() const {
  std::vector<SphereLoad> loads;
  for (const auto& [tag, load] : mean_loads_) loads.push_back(load);
  return loads;
}

/// Of what lies in the box; a corner that sticks out through two walls counts twice.
template <class Real>
Vec3 Simulation<Real>::buoyancy(const SphereState& sphere) const {
  const Settings& s = channel_.settings();
  const Grid& grid = channel_.grid();
  const double whole = 4.0 / 3.0 * std::numbers::pi * std::pow(sphere.radius, 3);
  double inside = whole;
  for (int d = 0; d < 3; ++d)
    if (!grid.periodic(d)) {
      const double below = -sphere.position[d];
      const double above = grid.length[static_cast<std::size_t>(d)] + below;
      inside -= whole - sphere_layer(sphere.radius, below, above).volume;
    }
  return -inside * s.fluid.density * Vec3(s.fluid.gravity.data());
}

// F = -J / dt - rho V g, J being what the markers gave to the fluid in the step, on each rank that
// the sphere is near
template <class Real>
std::vector<SphereLoad> Simulation<Real>::fixed_loads() const {
  std::vector<SphereLoad> loads;
  for (const SphereLoad& impulse : fixed_impulses_)
    loads.push_back({.tag = impulse.tag, .force = -impulse.force / channel_.last_time_step()});
  for (const SphereState& sphere : fixed_here())
    loads.push_back({.tag = sphere.tag, .force = buoyancy(sphere)});
  return loads;
}

template <class Real>
Vec3 Simulation<Real>::fixed_force() const {
  if (!has_fixed_) return Vec3::Zero();
  Vec3 given = Vec3::Zero();
  for (const SphereLoad& impulse : fixed_impulses_) given += impulse.force;
  MPI_Allreduce(MPI_IN_PLACE, given.data(), 3, MPI_DOUBLE, MPI_SUM, channel_.comm());
  return buoyancy_of_fixed_ - given / channel_.last_time_step();
}

template <class Real>
std::array<double, 2> Simulation<Real>::grain_stress() const {
  const auto& length = channel_.grid().length;
  const double area_and_time = length[0] * length[2] * channel_.last_time_step();
  return {account_.on_walls[0] / area_and_time, account_.on_walls[1] / area_and_time};
}

template <class Real>
double Simulation<Real>::momentum_residual() const {
  const double fluid = std::abs(channel_.momentum_residual());
  if (std::isnan(fluid)) return partner_ ? account_.momentum_residual : fluid;
  return std::max(fluid, account_.momentum_residual);
}

template class Simulation<float>;
template class Simulation<double>;

}  // namespace bedload
