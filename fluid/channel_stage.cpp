#include <algorithm>
#include <cmath>

#include "fluid/channel.hpp"
#include "fluid/diagnostics.hpp"
#include "fluid/prefetch.hpp"
#include "fluid/projection.hpp"

// One Runge-Kutta stage: predictor, forcing, projection, as sweeps over the planes.

namespace bedload {

/// Fixes the factors of the predictor and enters in the momentum budget what it will give.
template <class Real>
void Channel<Real>::begin_stage(int stage) {
  const Stage& rk = runge_kutta[static_cast<std::size_t>(stage)];
  const double h = grid_.h, nu = settings_.fluid.kinematic_viscosity, step = stage_step(stage);
  if (stage == 0) {
    driving_predicted_ = driving_;
    driving_this_step_ = 0.0;
    budget_ = {.begin = streamwise_sum_};
  }
  const double push = step * driving_predicted_;
  predictor_.begin_stage(
      {.factor = {.convection = static_cast<Real>(0.25 / h),
                  .diffusion = static_cast<Real>(implicit() ? step * nu / (h * h) : nu / (h * h)),
                  .gamma_dt = static_cast<Real>(rk.gamma * dt_),
                  .zeta_dt = static_cast<Real>(rk.zeta * dt_),
                  .pressure = static_cast<Real>(step / h)},
       .push = {static_cast<Real>(push), Real(0), Real(0)},
       .convection = settings_.fluid.convection,
       .pressure = keeps_old_pressure(),
       .old_tendency = stage > 0,
       .keep_tendency = stage + 1 < stage_count,
       .implicit = implicit()});
  budget_.given += push * grid_.cubes();
  const double walls = nu / (h * h) * local_wall_sum();
  budget_.walls += implicit() ? dt_ * rk.before * walls
                              : dt_ * (rk.gamma * walls + rk.zeta * budget_.walls_last);
  budget_.walls_last = walls;
}

/// Sum over the cells beside the walls of u beyond the wall minus u, times the area of the wall
/// over the distance across it: the wall's share of h^2 times the sum of the Laplacian.
template <class Real>
double Channel<Real>::local_wall_sum() const {
  const int nx = grid_.cells[0], nz = slabs_.rows(), top = slabs_.planes() - 1;
  double sum = 0.0;
  const auto across = [&](int ghost_plane, int ghost_row, int plane, int row) {
    return row_sum(nx, velocity_.row(ghost_plane, ghost_row)) -
           row_sum(nx, velocity_.row(plane, row));
  };
  for (int k = 0; k < nz; ++k) {
    if (slabs_.at_lower_wall()) sum += across(-1, k, 0, k) / grid_.gap(-1);
    if (slabs_.at_upper_wall()) sum += across(top + 1, k, top, k) / grid_.gap(grid_.cells[1] - 1);
  }
  for (int j = 0; j <= top; ++j) {
    const double thickness = grid_.thickness(slabs_.first() + j);
    if (slabs_.at_back_wall()) sum += thickness * across(j, -1, j, 0);
    if (slabs_.at_front_wall()) sum += thickness * across(j, nz, j, nz - 1);
  }
  return sum;
}

/// Plane j of u* into the storage of the plane that the sweep comes from.
template <class Real>
template <class EachRow>
void Channel<Real>::predict_plane(int j, EachRow each_row) {
  const bool under_wall = slabs_.at_upper_wall() && j == slabs_.planes() - 1;
  predictor_.plane(j, forth_, [&](int k) {
    if (under_wall) close_wall_face(j - step_of(forth_), k);
    each_row(k);
  });
}

/// The upper wall's own face carries no flow.
template <class Real>
void Channel<Real>::close_wall_face(int j, int k) {
  std::fill_n(velocity_.row(j, k, 1) - 1, grid_.cells[0] + 2, Real(0));
}

/// u* of one stage with implicit diffusion, in place: the solver of each component gives
///
///   d - after dt nu L d = rhs    as    (h^2 L - s) d = -s rhs,   s = h^2 / (after dt nu),
///
/// and u* = u + d.
template <class Real>
void Channel<Real>::diffuse(int stage) {
  const int nx = grid_.cells[0], nz = slabs_.rows(), planes = slabs_.planes();
  const double h2 = grid_.h * grid_.h, nu = settings_.fluid.kinematic_viscosity;
  const double after = runge_kutta[static_cast<std::size_t>(stage)].after * dt_;
  const double shift = h2 / (after * nu);
  for (PoissonSolver<Real>& solver : diffusion_) solver.set_shift(shift);
  for (int n = 0; n < planes; ++n) {
    const int j = plane_of(forth_, n, planes);
    const auto rhs_row = [&](int c, int k) {
      return diffusion_[static_cast<std::size_t>(c)].rhs_row(j, k);
    };
    predictor_.implicit_plane(j, rhs_row);
    // What flows through walls does not change.
    if (!grid_.periodic(0))
      for (int k = 0; k < nz; ++k) rhs_row(0, k)[nx - 1] = Real(0);
    if (slabs_.at_front_wall()) std::fill_n(rhs_row(2, nz - 1), nx, Real(0));
    if (slabs_.at_upper_wall() && j == planes - 1)
      for (int k = 0; k < nz; ++k) std::fill_n(rhs_row(1, k), nx, Real(0));
    if (slabs_.divides_rows())  // nothing for the block in front
      for (int c = 0; c < 3; ++c) std::fill_n(rhs_row(c, nz), nx, Real(0));
    clock_.lap(FlowPhase::momentum);
    const double cell = grid_.thickness(slabs_.first() + j), face = grid_.gap(slabs_.first() + j);
    diffusion_[0].eliminate(j, -shift * cell);
    diffusion_[1].eliminate(j, -shift * face);
    diffusion_[2].eliminate(j, -shift * cell);
    clock_.lap(FlowPhase::elimination);
  }
  for (PoissonSolver<Real>& solver : diffusion_) solver.couple();
  for (int n = 0; n < planes; ++n) {
    const int j = plane_of(opposite(forth_), n, planes);
    for (PoissonSolver<Real>& solver : diffusion_) solver.substitute(j);
    for (int k = 0; k < nz; ++k) {
      if (k + 1 < nz) ask_to_write(velocity_.row_block(j, k + 1), velocity_.row_size());
      for (int c = 0; c < 3; ++c) {
        Real* q = velocity_.row(j, k, c);
        const Real* d = diffusion_[static_cast<std::size_t>(c)].solution_row(j, k);
        for (int i = 0; i < nx; ++i) q[i] += d[i];
        walls_.close_row(q, c);
      }
    }
    walls_.close_plane(velocity_, j);
    clock_.lap(FlowPhase::substitution);
  }
  walls_.close_block(velocity_);
  budget_.walls += after * nu / h2 * local_wall_sum();
}

/// Of plane j, whose u* stands in the storage of plane j + moved.
template <class Real>
typename Channel<Real>::Outflow Channel<Real>::outflow(int j, int moved, double step) const {
  const double thickness = grid_.thickness(slabs_.first() + j);
  return {.j = j,
          .at = j + moved,
          .waits_for_below = j == 0 || forth_ == Sweep::down,
          .thickness = thickness,
          .in_plane = static_cast<Real>(thickness * grid_.h / step),
          .upwards = static_cast<Real>(grid_.h / step)};
}

/// Puts h/(step) (div u*) h of row k, times the plane's height over h, into the Poisson solver's
/// plane and adds up u*. What the block below lets in is added by couple(), what the block behind
/// lets in comes with the sweep.
template <class Real>
void Channel<Real>::take_row(Outflow& flow, int k) {
  const int nx = grid_.cells[0], at = flow.at;
  const Real* v_below = flow.waits_for_below ? zeros_.data() : velocity_.row(at - 1, k, 1);
  const Real* w_back =
      k == 0 && poisson_.gives_to_front() ? zeros_.data() : velocity_.row(at, k - 1, 2);
  divergence_row(nx, flow.in_plane, flow.upwards, velocity_.row(at, k, 0), velocity_.row(at, k, 1),
                 v_below, velocity_.row(at, k, 2), w_back, poisson_.rhs_row(flow.j, k));
  flow.sum += row_sum(nx, velocity_.row(at, k, 0));
}

/// What plane `flow` gets through its lower face, once u* of the plane below is there.
template <class Real>
void Channel<Real>::take_row_below(const Outflow& flow, int k) {
  const Real* v_below = velocity_.row(flow.at - 1, k, 1);
  Real* rhs = poisson_.rhs_row(flow.j, k);
  for (int i = 0; i < grid_.cells[0]; ++i) rhs[i] -= flow.upwards * v_below[i];
}

/// Eliminates a plane, all of whose rows have been taken.
template <class Real>
void Channel<Real>::eliminate_plane(const Outflow& flow) {
  const int nx = grid_.cells[0], nz = slabs_.rows();
  local_sum_ += flow.sum * flow.thickness;
  if (poisson_.gives_to_front()) {
    const Real* w = velocity_.row(flow.at, nz - 1, 2);
    Real* given = poisson_.rhs_row(flow.j, nz);
    for (int i = 0; i < nx; ++i) given[i] = -flow.in_plane * w[i];
  }
  if (!slabs_.at_upper_wall() && flow.j == slabs_.planes() - 1)
    for (int k = 0; k < nz; ++k) {
      const Real* v = velocity_.row(flow.at, k, 1);
      Real* excess = poisson_.excess_row(k);
      const Real over_gap = flow.upwards * static_cast<Real>(grid_.gap(slabs_.first() + flow.j));
      for (int i = 0; i < nx; ++i) excess[i] = over_gap * v[i];
    }
  clock_.lap(FlowPhase::divergence);
  poisson_.eliminate(flow.j);
  clock_.lap(FlowPhase::elimination);
}

/// The same for a plane whose u* is whole, as is that of the plane below.
template <class Real>
void Channel<Real>::eliminate_plane(int j, int moved, double step) {
  Outflow flow = outflow(j, moved, step);
  for (int k = 0; k < slabs_.rows(); ++k) {
    take_row(flow, k);
    if (forth_ == Sweep::down && j > 0) take_row_below(flow, k);
  }
  eliminate_plane(flow);
}

template <class Real>
void Channel<Real>::predict(int stage) {
  if (boundary_) boundary_->start_stage(velocity_);
  begin_stage(stage);
  clock_.start();
  predicted_ = slabs_.planes();
  if (implicit()) {
    diffuse(stage);
  } else {
    // Whoever asks for the flow's energy between predictor and projection wants all planes.
    if (boundary_ && !fringe_.on() && !settings_.output.energy_work)
      predicted_ = boundary_->planes_reached();
    for (int n = 0; n < predicted_; ++n)
      predict_plane(plane_of(forth_, n, slabs_.planes()), [](int) {});
    clock_.lap(FlowPhase::momentum);
    velocity_.relabel(step_of(forth_));
  }
  budget_.walls += fringe_.apply(velocity_, slabs_.first(), stage_step(stage));
}

template <class Real>
std::vector<SphereLoad> Channel<Real>::force_spheres(int stage) {
  if (!boundary_) return {};
  boundary_->force(velocity_, stage_step(stage));
  if (slabs_.at_upper_wall() && predicted_ == slabs_.planes())
    for (int k = 0; k < slabs_.rows(); ++k) close_wall_face(slabs_.planes() - 1, k);
  budget_.walls += stage_step(stage) * boundary_->force_on_fluid()[0] /
                   (settings_.fluid.density * grid_.cell_volume());
  return boundary_->loads(stage_step(stage));
}

template <class Real>
void Channel<Real>::project(int stage) {
  local_sum_ = 0.0;
  clock_.start();
  for (int n = 0; n < predicted_; ++n)
    eliminate_plane(plane_of(forth_, n, slabs_.planes()), 0, stage_step(stage));
  if (predicted_ < slabs_.planes()) {
    velocity_.relabel(-step_of(forth_));
    predict_and_eliminate(predicted_, stage);
  }
  couple_and_correct(stage);
}

template <class Real>
void Channel<Real>::advance_stage(int stage) {
  if (fringe_.on() || implicit()) {
    predict(stage);
    return project(stage);
  }
  begin_stage(stage);
  local_sum_ = 0.0;
  clock_.start();
  predict_and_eliminate(0, stage);
  couple_and_correct(stage);
}

/// Predicts and eliminates from the `first` plane of the sweep on, each plane while it is in the
/// cache. The outflow of a row is taken as soon as it is there, but for the first and last one,
/// which need what closes the plane. On the way down a plane's outflow is whole when the plane
/// below is predicted.
template <class Real>
void Channel<Real>::predict_and_eliminate(int first, int stage) {
  const int planes = slabs_.planes(), last_row = slabs_.rows() - 1;
  const bool down = forth_ == Sweep::down;
  Outflow before{};
  for (int n = first; n < planes; ++n) {
    const int j = plane_of(forth_, n, planes);
    Outflow flow = outflow(j, -step_of(forth_), stage_step(stage));
    const auto take = [&](int k) {
      take_row(flow, k);
      if (down && n > first) take_row_below(before, k);
    };
    predict_plane(j, [&](int k) {
      const int whole = down ? k + 1 : k;  // needs w* of the row behind
      if (whole > 0 && whole < last_row) take(whole);
    });
    clock_.lap(FlowPhase::momentum);
    take(0);
    if (last_row > 0) take(last_row);
    if (!down) eliminate_plane(flow);
    if (down && n > first) eliminate_plane(before);
    before = flow;
  }
  if (down) eliminate_plane(before);
  velocity_.relabel(step_of(forth_));
}

template <class Real>
void Channel<Real>::couple_and_correct(int stage) {
  const double step = stage_step(stage);
  const double shift = bulk_shift(step);
  poisson_.couple();
  clock_.lap(FlowPhase::coupling);
  const bool last = stage + 1 == stage_count;
  substitute_and_correct({.step = step,
                          .shift = shift,
                          .measure = last,
                          .moved = implicit() ? 0 : step_of(forth_),
                          .pressure = keeps_old_pressure() ? PressureUse::add
                                      : last               ? PressureUse::replace
                                                           : PressureUse::none});
  fill_ghosts();
  clock_.lap(FlowPhase::halo);
}

/// What u needs everywhere so that its mean is the wanted bulk velocity: the projection leaves the
/// mean of u* alone, so it is known before. The driving of the stage follows from it.
template <class Real>
double Channel<Real>::bulk_shift(double step) {
  double sum = local_sum_;
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm());
  if (!std::isfinite(sum)) report_not_finite();  // before the transforms spread it everywhere
  double shift = 0.0;
  if (settings_.flow.driving == Driving::bulk_velocity)
    // The fields can only take the shift as rounded to their precision.
    shift = static_cast<Real>(settings_.flow.bulk_velocity - sum / grid_.cubes());
  budget_.given += shift * grid_.cubes();
  driving_this_step_ += (step * driving_predicted_ + shift) / dt_;
  return shift;
}

/// u = u* - step grad phi + shift; where the predictor moved the planes, each one back into its
/// place.
template <class Real>
void Channel<Real>::substitute_and_correct(const Correction& correction) {
  local_sum_ = local_fastest_ = 0.0;
  for (int n = 0; n < slabs_.planes(); ++n) {
    const int j = plane_of(opposite(forth_), n, slabs_.planes());
    substitute_to_correct(j, correction.pressure);
    clock_.lap(FlowPhase::substitution);
    correct_plane(j, correction);
    clock_.lap(FlowPhase::correction);
  }
  velocity_.relabel(-correction.moved);
}

/// What is still missing of phi in plane j and in the one above, which the correction of plane j
/// needs.
template <class Real>
void Channel<Real>::substitute_to_correct(int j, PressureUse pressure) {
  const int top = slabs_.planes() - 1;
  if (forth_ == Sweep::up) {
    if (j == top && !slabs_.at_upper_wall()) {
      poisson_.substitute(top + 1);
      update_pressure(top + 1, pressure);
    }
    poisson_.substitute(j);
  } else {
    if (j == 0) poisson_.substitute(0);
    if (j < top) poisson_.substitute(j + 1);
  }
}

/// One plane of it, with the plane's share of what the last stage measures.
template <class Real>
void Channel<Real>::correct_plane(int j, const Correction& correction) {
  const int nx = grid_.cells[0], nz = slabs_.rows(), global = slabs_.first() + j;
  const bool under_wall = slabs_.at_upper_wall() && j == slabs_.planes() - 1;
  const Real factor = static_cast<Real>(correction.step / grid_.h);
  const Real factor_y = static_cast<Real>(correction.step / grid_.h / grid_.gap(global));
  const Real shift = static_cast<Real>(correction.shift);
  const Real stretch = static_cast<Real>(stretch_at(grid_, global));
  double sum = 0.0;
  Real fastest = 0;
  for (int k = 0; k < nz; ++k) {
    const Real* phi = poisson_.solution_row(j, k);
    Real* to = velocity_.row(j + correction.moved, k);
    correct_row(nx, factor, factor_y, shift, velocity_.component_stride(), velocity_.row(j, k), to,
                phi, under_wall ? phi : poisson_.solution_row(j + 1, k),
                poisson_.solution_row(j, k + 1));
    for (int c = 0; c < 3; ++c)
      walls_.close_row(to + static_cast<std::size_t>(c) * velocity_.component_stride(), c);
    if (!correction.measure) continue;
    sum += row_sum(nx, to);
    fastest = std::max(fastest, largest_speed(nx, stretch, velocity_.component_stride(), to));
  }
  walls_.close_plane(velocity_, j + correction.moved);
  local_sum_ += sum * grid_.thickness(global);
  local_fastest_ = std::max(local_fastest_, static_cast<double>(fastest));
  update_pressure(j, correction.pressure);
}

/// p + s phi where the predictor had the old pressure gradient (s < 1 with spheres: the whole would
/// make them swing by their added mass, spheres/README.md), phi itself where it had none (the
/// projection then yields the same velocity, and phi of the last stage is the pressure).
template <class Real>
void Channel<Real>::update_pressure(int j, PressureUse use) {
  if (use == PressureUse::none) return;
  const int nx = grid_.cells[0];
  const Real share = boundary_ ? static_cast<Real>(settings_.spheres.pressure_share) : Real(1);
  for (int k = 0; k < slabs_.rows() + (poisson_.gives_to_front() ? 1 : 0); ++k) {
    const Real* phi = poisson_.solution_row(j, k);
    Real* p = pressure_.row(j, k);
    if (use == PressureUse::replace)
      for (int i = 0; i < nx; ++i) p[i] = phi[i];
    else
      for (int i = 0; i < nx; ++i) p[i] += share * phi[i];
  }
  walls_.close_scalar(pressure_, j);
}

template <class Real>
void Channel<Real>::fill_ghosts() {
  slabs_.exchange_rows(velocity_);
  if (slabs_.divides_rows())  // a block of one row reflects its neighbour's at the wall
    for (int j = 0; j < slabs_.planes(); ++j) walls_.close_plane(velocity_, j);
  slabs_.exchange_planes(velocity_);
  walls_.close_block(velocity_);
}

template class Channel<float>;
template class Channel<double>;

}  // namespace bedload
