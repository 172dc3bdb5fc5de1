#include "coupling/simulation.hpp"

#include <algorithm>
#include <cmath>

#include "coupling/stages.hpp"
#include "fluid/runge_kutta.hpp"

namespace bedload {

static_assert(dem_substeps.size() == stage_count);

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
                             std::span<const SphereState> spheres)
    : channel_(settings, comm, spheres),
      partner_(partner),
      phases_(timing_, partner != nullptr || !spheres.empty(), partner != nullptr),
      spheres_(spheres.begin(), spheres.end()) {}

// The Runge-Kutta stages of one step. While the pressure is solved, which needs nothing of the
// grains, LIGGGHTS moves them by the loads of the same stage, in 8, 2 and 5 steps of its own.
template <class Real>
void Simulation<Real>::make_step(bool last) {
  begin_step();
  for (int stage = 0; stage < stage_count; ++stage) {
    if (spheres_.empty() && !partner_) {
      timing_.measure(phases_.flow, [&] { channel_.advance_stage(stage); });
      continue;
    }
    timing_.measure(phases_.predictor, [&] { channel_.predict(stage); });
    loads_ = timing_.measure(phases_.markers, [&] { return channel_.force_spheres(stage); });
    if (!partner_) {
      timing_.measure(phases_.pressure, [&] { channel_.project(stage); });
      continue;
    }
    timing_.measure(phases_.exchange,
                    [&] { partner_->send_loads(stage, channel_.time_step(), last, loads_); });
    timing_.measure(phases_.pressure, [&] { channel_.project(stage); });
    motion_ = timing_.measure(phases_.waiting, [&] { return partner_->receive_motion(); });
    timing_.measure(phases_.markers, [&] { move_spheres(); });
    take_note(stage);
  }
  timing_.measure(phases_.closing, [&] { channel_.finish_step(); });
}

template <class Real>
void Simulation<Real>::begin_step() {
  mean_loads_.clear();
  grain_intervals_.clear();
  exchange_residual_ = 0.0;
}

template <class Real>
void Simulation<Real>::move_spheres() {
  std::erase_if(spheres_, [](const SphereState& s) { return s.mobile; });
  spheres_.insert(spheres_.end(), motion_.mobile.begin(), motion_.mobile.end());
  if (motion_.same_spheres)
    channel_.move_spheres(motion_.mobile);
  else
    channel_.set_spheres(spheres_);
}

// mean of F over the step = sum over the stages of 2 alpha_k F_k
template <class Real>
void Simulation<Real>::take_note(int stage) {
  const double weight = runge_kutta[static_cast<std::size_t>(stage)].two_alpha;
  for (const SphereLoad& load : loads_) {
    SphereLoad& mean = mean_loads_.try_emplace(load.tag, SphereLoad{load.tag}).first->second;
    mean.force += weight * load.force;
    mean.torque += weight * load.torque;
  }
  exchange_residual_ = std::max(exchange_residual_, motion_.momentum_residual);
  grain_intervals_.push_back({motion_.dem_began, motion_.dem_ended});
}

template <class Real>
std::vector<SphereLoad> Simulation<Real>::mean_loads() const {
  std::vector<SphereLoad> loads;
  for (const auto& [tag, load] : mean_loads_) loads.push_back(load);
  return loads;
}

template <class Real>
std::int64_t Simulation<Real>::mobile_count() const {
  return std::count_if(spheres_.begin(), spheres_.end(),
                       [](const SphereState& s) { return s.mobile; });
}

template <class Real>
double Simulation<Real>::momentum_residual() const {
  return std::max(std::abs(channel_.momentum_residual()), exchange_residual_);
}

template class Simulation<float>;
template class Simulation<double>;

}  // namespace bedload
