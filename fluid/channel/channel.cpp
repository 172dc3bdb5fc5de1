#include "fluid/channel/channel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fluid/channel/diagnostics.hpp"
#include "fluid/channel/start_field.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/grid/diffusion_limit.hpp"
#include "fluid/grid/division.hpp"
#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/validation/validate.hpp"

namespace bedload {
template <class Real>
Channel<Real>::Channel(const Settings& settings, MPI_Comm comm,
                       std::span<const SphereState> spheres, const Cuts& cuts)
    : settings_(settings),
      grid_(make_grid(settings)),
      decomposition_(grid_, comm,
                     cuts.y.empty() ? choose_cuts(grid_, spheres, size_of(comm),
                                                  settings.ranks.along_z, settings.spheres)
                                    : cuts),
      walls_(grid_, decomposition_),
      fields_(grid_, decomposition_.extent()),
      velocity_(fields_[Stored::velocity]),
      pressure_(fields_[Stored::pressure]),
      tendency_(grid_, decomposition_.extent(), 3, 0, Ghosts::none),
      predictor_(grid_, decomposition_, walls_, velocity_, tendency_, pressure_,
                 tiles<Real>(grid_.cells[0], decomposition_.rows())),
      diffusion_(diffusion_is_implicit(settings_, grid_), settings_.fluid.kinematic_viscosity,
                 grid_, decomposition_, walls_),
      projection_(grid_, decomposition_, walls_, velocity_, pressure_, clock_,
                  pressure_tiles<Real>(grid_.cells[0], decomposition_.rows()),
                  predictor_.planes_at_once()),
      fringe_(settings.fringe, grid_),
      driving_(settings_),
      limits_(settings_, grid_),
      dt_(settings.time.step),
      dt_made_(dt_) {
  write_start_field(velocity_, settings_, grid_, decomposition_);
  project_start_field();
  shift_to_bulk_velocity();
  walls_.close_own_planes(velocity_);
  walls_.fill(velocity_);
  measure_start();
  set_spheres(spheres);
}

template <class Real>
Channel<Real>::~Channel() = default;

template <class Real>
void Channel<Real>::set_spheres(std::span<const SphereState> spheres) {
  int any = spheres.empty() ? 0 : 1;  // near this rank's block; it has a part in forcing the others
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm());
  if (any == 0 && !boundary_) return;
  collectively(comm(), [&] { check_in_cubes(settings_.file, grid_, spheres); });
  if (!boundary_)
    boundary_ = std::make_unique<ImmersedBoundary<Real>>(settings_, grid_, decomposition_);
  boundary_->set_spheres(spheres);
}

template <class Real>
void Channel<Real>::move_spheres(std::span<const SphereState> moved, double last_step) {
  check_in_cubes(settings_.file, grid_, moved);
  if (!boundary_)
    boundary_ = std::make_unique<ImmersedBoundary<Real>>(settings_, grid_, decomposition_);
  boundary_->move_spheres(moved, last_step, next_stage_ == 0);
}

template <class Real>
double Channel<Real>::momentum_rounding() const {
  constexpr double of_sum = 1e-6;  // 1e-13 in double, 6e-8 seen in single
  if (!diffusion_.on()) return of_sum;
  constexpr double of_elimination = 0.3;  // a tenth is seen, without spheres
  const double length = settings_.fluid.kinematic_viscosity * dt_made_ / (grid_.h * grid_.h);
  return std::max(of_sum, of_elimination * std::numeric_limits<Real>::epsilon() * length);
}

template <class Real>
void Channel<Real>::finish_step() {
  time_ += dt_;
  dt_made_ = dt_;
  ++step_;
  driving_.end_step();
  double sums[2] = {projection_.local_sum(), budget_.local()};
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, comm());
  fastest_ = projection_.local_fastest();
  MPI_Allreduce(MPI_IN_PLACE, &fastest_, 1, MPI_DOUBLE, MPI_MAX, comm());
  streamwise_sum_ = sums[0];
  const double scale = fastest_ * grid_.cubes();
  const double residual = budget_.residual(sums[0], sums[1]);
  momentum_residual_ = scale > 0.0 ? residual / scale : residual;
  choose_time_step();
  check_field();
}

template <class Real>
void Channel<Real>::choose_time_step() {
  if (std::isfinite(fastest_)) dt_ = limits_.step(fastest_);
}

/// Names the first value that is not finite.
template <class Real>
void Channel<Real>::report_not_finite() const {
  const BadPlace bad = find_not_finite(velocity_, decomposition_);
  struct {
    int missing, rank;
  } first{bad.found ? 0 : 1, decomposition_.rank()};
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_2INT, MPI_MINLOC, comm());
  int place[4] = {bad.i, bad.j, bad.k, bad.component};
  MPI_Bcast(place, 4, MPI_INT, first.rank, comm());
  throw UserError(fmt::format(
      "{}: after step {} (t = {:.6g}): the {} velocity near cell ({}, {}, {}) is not finite; "
      "reduce "
      "'time.step' ({}).",
      settings_.file, step_, time_, "uvw"[place[3]], place[0], place[1], place[2], dt_));
}

/// Refuses a step that is too long before the numbers turn into noise.
template <class Real>
void Channel<Real>::check_field() const {
  if (!std::isfinite(streamwise_sum_) || !std::isfinite(fastest_)) report_not_finite();
  if (limits_.allows(cfl(), dt_)) return;
  throw UserError(
      limits_.complaint(step_, time_, dt_, cfl(), find_fastest(velocity_, grid_, decomposition_)));
}

template <class Real>
double Channel<Real>::max_divergence() const {
  return largest_divergence(velocity_, grid_, decomposition_);
}

template <class Real>
double Channel<Real>::kinetic_energy() const {
  return settings_.fluid.density * kinetic_energy_integral(velocity_, grid_, decomposition_);
}

template <class Real>
double Channel<Real>::viscous_loss() const {
  return -settings_.fluid.density * settings_.fluid.kinematic_viscosity / (grid_.h * grid_.h) *
         viscous_power_integral(velocity_, velocity_, grid_, decomposition_);
}

template <class Real>
double Channel<Real>::wall_power() const {
  return settings_.fluid.density * settings_.fluid.kinematic_viscosity / (grid_.h * grid_.h) *
         wall_power_integral(velocity_, grid_, decomposition_);
}

template <class Real>
std::array<double, 2> Channel<Real>::wall_stress() const {
  return mean_wall_stress(velocity_, grid_, decomposition_,
                          settings_.fluid.density * settings_.fluid.kinematic_viscosity);
}

template class Channel<float>;
template class Channel<double>;

}  // namespace bedload
