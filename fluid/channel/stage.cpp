#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "fluid/channel/channel.hpp"
#include "fluid/channel/diagnostics.hpp"

// One Runge-Kutta stage: predict, force, project.

namespace bedload {

template <class Real>
void Channel<Real>::predict(int stage, bool all_planes) {
  all_planes = all_planes || diffusion_.on() || fringe_.on();
  if (boundary_) boundary_->start_stage(velocity_);
  old_pressure_planes_ = old_pressure_planes(all_planes);
  begin_stage(stage);
  clock_.start();
  // What nothing needs before the projection is predicted there, while it is in the cache.
  predicted_ = all_planes ? decomposition_.planes() : boundary_ ? boundary_->planes_reached() : 0;
  if (diffusion_.on()) {
    diffuse(stage);
  } else {
    const int at_once = predictor_.planes_at_once();
    for (int j = 0; j < predicted_; j += at_once)
      predict_planes(j, std::min(j + at_once, predicted_), [](int, int) {});
    clock_.lap(FlowPhase::momentum);
    velocity_.relabel(1);
  }
  budget_.add_local(fringe_.apply(velocity_, decomposition_.first(), stage_step(stage)));
}

template <class Real>
std::vector<SphereLoad> Channel<Real>::force_spheres(int stage) {
  next_stage_ = (stage + 1) % stage_count;
  if (!boundary_) return {};
  boundary_->force(velocity_, stage_step(stage), stage == 0 ? time_step() : 0.0);
  const int top = decomposition_.planes() - 1;
  if (decomposition_.at_upper_wall() && predicted_ > top)
    for (int k = 0; k < decomposition_.rows(); ++k) walls_.close_wall_face(velocity_, top, k);
  budget_.add_local(stage_step(stage) * boundary_->force_on_fluid()[0] /
                    (settings_.fluid.density * grid_.cell_volume()));
  const bool spheres_move =
      settings_.coupling.exchange == Exchange::stage || stage + 1 == stage_count;
  return boundary_->loads(stage_step(stage), spheres_move);
}

template <class Real>
void Channel<Real>::project(int stage) {
  clock_.start();
  projection_.begin();
  projection_.eliminate_planes(0, predicted_, stage_step(stage));
  if (predicted_ < decomposition_.planes()) predict_and_eliminate(predicted_, stage);
  const double shift = bulk_shift(stage_step(stage));
  projection_.couple();
  clock_.lap(FlowPhase::coupling);
  const bool last = stage + 1 == stage_count;
  using PressureUse = typename PressureProjection<Real>::PressureUse;
  projection_.correct({.step = stage_step(stage),
                       .shift = shift,
                       .measure = last,
                       .moved = diffusion_.on() ? 0 : 1,
                       .pressure = PressureUse::add,
                       .pressure_planes = old_pressure_planes_,
                       .pressure_above = last ? PressureUse::replace : PressureUse::none,
                       .pressure_share = boundary_ ? boundary_->pressure_share() : 1.0});
  walls_.fill(velocity_);
  clock_.lap(FlowPhase::halo);
}

/// Own planes whose predictor has the old pressure gradient: those that something acts on before
/// the projection, and one more, because v between the last one and those without comes out wrong
/// until the projection. There it is the gradient of a pressure that is zero above, so that the
/// projected velocity is the same. A periodic y has no above: all of them then.
template <class Real>
int Channel<Real>::old_pressure_planes(bool all_planes) const {
  if (!keeps_old_pressure()) return 0;
  const int all = std::numeric_limits<int>::max();
  if (all_planes || grid_.periodic(1)) return all;
  const int planes = boundary_->highest_reached() + 1;
  return planes >= grid_.cells[1] ? all : planes - decomposition_.first();
}

/// Fixes the factors of the predictor and enters in the momentum budget what it will give.
template <class Real>
void Channel<Real>::begin_stage(int stage) {
  const Stage& rk = runge_kutta[static_cast<std::size_t>(stage)];
  const double h = grid_.h, nu = settings_.fluid.kinematic_viscosity, step = stage_step(stage);
  const bool implicit = diffusion_.on();
  if (stage == 0) {
    driving_.begin_step();
    budget_.begin_step(streamwise_sum_);
  }
  const double push = step * driving_.predicted();
  predictor_.begin_stage(
      {.factor = {.convection = static_cast<Real>(0.25 / h),
                  .diffusion = static_cast<Real>(implicit ? step * nu / (h * h) : nu / (h * h)),
                  .gamma_dt = static_cast<Real>(rk.gamma * dt_),
                  .zeta_dt = static_cast<Real>(rk.zeta * dt_),
                  .pressure = static_cast<Real>(step / h)},
       .push = {static_cast<Real>(push), Real(0), Real(0)},
       .convection = settings_.fluid.convection,
       .pressure = keeps_old_pressure(),
       .pressure_planes = old_pressure_planes_,
       .old_tendency = stage > 0,
       .keep_tendency = stage + 1 < stage_count,
       .implicit = implicit});
  budget_.add_driving(push * grid_.cubes());
  budget_.add_walls(rk, dt_, nu / (h * h) * local_wall_sum(velocity_, grid_, decomposition_),
                    implicit);
}

/// Planes of u* into the storage of the planes below.
template <class Real>
template <class EachRow>
void Channel<Real>::predict_planes(int first, int end, EachRow each_row) {
  const int under_wall = decomposition_.at_upper_wall() ? decomposition_.planes() - 1 : -1;
  predictor_.planes(first, end, [&](int j, int k) {
    if (j == under_wall) walls_.close_wall_face(velocity_, j - 1, k);
    each_row(j, k);
  });
}

/// u* with implicit diffusion, which knows of the markers' kept force; what the walls give at the
/// end of the stage is known then.
template <class Real>
void Channel<Real>::diffuse(int stage) {
  const double after = runge_kutta[static_cast<std::size_t>(stage)].after * dt_;
  typename ImplicitDiffusion<Real>::Kick kick;
  if (boundary_)
    kick = {.change = &boundary_->spread_kept_force(stage_step(stage), dt_),
            .planes = boundary_->planes_reached_here()};
  diffusion_.solve(predictor_, velocity_, after, kick, clock_);
  if (boundary_) boundary_->clear_kept_force();
  budget_.add_local(after * settings_.fluid.kinematic_viscosity / (grid_.h * grid_.h) *
                    local_wall_sum(velocity_, grid_, decomposition_));
}

/// Predicts and eliminates from plane `first` on, some planes at a time while they are in the
/// cache. The outflow of a row is taken as soon as it is there, but for the first and last one,
/// which need what closes the plane.
template <class Real>
void Channel<Real>::predict_and_eliminate(int first, int stage) {
  const int planes = decomposition_.planes(), last_row = decomposition_.rows() - 1;
  velocity_.relabel(-1);
  std::vector<typename PressureProjection<Real>::Outflow> flows;
  for (int begin = first; begin < planes; begin += predictor_.planes_at_once()) {
    const int end = std::min(begin + predictor_.planes_at_once(), planes);
    flows.clear();
    for (int j = begin; j < end; ++j)
      flows.push_back(projection_.outflow(j, j - 1, stage_step(stage)));
    predict_planes(begin, end, [&](int j, int k) {
      if (k > 0 && k < last_row)
        projection_.take_row(flows[static_cast<std::size_t>(j - begin)], k);
    });
    clock_.lap(FlowPhase::momentum);
    for (auto& flow : flows) {
      projection_.take_row(flow, 0);
      if (last_row > 0) projection_.take_row(flow, last_row);
    }
    projection_.eliminate_planes(flows);
  }
  velocity_.relabel(1);
}

/// What u needs everywhere so that its mean is the wanted bulk velocity: the projection leaves the
/// mean of u* alone, so it is known before. The driving of the stage follows from it.
template <class Real>
double Channel<Real>::bulk_shift(double step) {
  double sum = projection_.local_sum();
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm());
  if (!std::isfinite(sum)) report_not_finite();  // before the transforms spread it everywhere
  const double shift = driving_.missing<Real>(sum / grid_.cubes());
  budget_.add_driving(shift * grid_.cubes());
  driving_.count(step, dt_, shift);
  return shift;
}

template class Channel<float>;
template class Channel<double>;

}  // namespace bedload
