#include "fluid/channel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fluid/diagnostics.hpp"
#include "fluid/diffusion.hpp"
#include "fluid/division.hpp"
#include "fluid/errors.hpp"
#include "fluid/projection.hpp"
#include "fluid/start_field.hpp"

namespace bedload {
namespace {

int rank_count(MPI_Comm comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  return ranks;
}

/// Two slabs both begin at their wall and meet in the middle; of more, the uppermost one does so.
/// Among spheres all go upwards (predict() leaves out the planes above them).
Sweep direction_of(const Decomposition& slabs, bool spheres) {
  return !spheres && slabs.at_upper_wall() && !slabs.at_lower_wall() ? Sweep::down : Sweep::up;
}

}  // namespace

template <class Real>
Channel<Real>::Channel(const Settings& settings, MPI_Comm comm,
                       std::span<const SphereState> spheres, const Cuts& cuts)
    : settings_(settings),
      grid_(make_grid(settings)),
      slabs_(grid_, comm,
             cuts.y.empty() ? choose_cuts(grid_, spheres, rank_count(comm), settings.ranks.along_z,
                                          settings.spheres.forcing_loops)
                            : cuts),
      walls_(grid_, slabs_),
      velocity_(grid_, slabs_.extent(), 3, 1),
      tendency_(grid_, slabs_.extent(), 3, 0, Ghosts::none),
      pressure_(grid_, slabs_.extent(), 1),
      predictor_(grid_, slabs_, walls_, velocity_, tendency_, pressure_),
      forth_(direction_of(slabs_, !spheres.empty())),
      poisson_(grid_, slabs_, pressure_component, forth_),
      fringe_(settings.fringe, grid_),
      zeros_(static_cast<std::size_t>(grid_.cells[0]), Real(0)),
      dt_(settings.time.step),
      dt_made_(dt_) {
  check_settings();
  if (forth_ == Sweep::down) velocity_.relabel(1);  // the spare plane is wanted above
  if (diffusion_is_implicit(settings_, grid_)) {
    diffusion_.reserve(3);
    for (int c = 0; c < 3; ++c) diffusion_.emplace_back(grid_, slabs_, c, forth_);
  }
  set_driving(0.0);
  write_start_field(velocity_, settings_, grid_, slabs_);
  project_start_field();
  if (settings_.flow.driving == Driving::bulk_velocity) {
    const Real shift = static_cast<Real>(settings_.flow.bulk_velocity -
                                         streamwise_sum(velocity_, grid_, slabs_) / grid_.cubes());
    for (int j = 0; j < slabs_.planes(); ++j)
      for (int k = 0; k < slabs_.rows(); ++k) {
        Real* u = velocity_.row(j, k, 0);
        for (int i = 0; i < grid_.cells[0]; ++i) u[i] += shift;
      }
    close_own_planes();
    fill_ghosts();
  }
  measure_start();
  if (!spheres.empty()) set_spheres(spheres);
}

template <class Real>
Channel<Real>::~Channel() = default;

template <class Real>
void Channel<Real>::check_settings() const {
  const double limit = explicit_diffusion_limit(grid_, settings_.fluid.kinematic_viscosity);
  if (!diffusion_is_implicit(settings_, grid_) && settings_.time.cfl == 0.0 && dt_ > limit)
    throw UserError(fmt::format(
        "{}: 'time.step' is {}, but explicit diffusion is stable only up to {:.4g} with "
        "this viscosity and cell size; 'fluid.diffusion' = \"implicit\" has no limit.",
        settings_.file, dt_, limit));
}

/// Markers need cubes around them.
template <class Real>
void Channel<Real>::check_height(std::span<const SphereState> spheres) const {
  constexpr double support = 2.0;  // cells from a surface to the outermost point that it touches
  if (!grid_.stretched()) return;
  const double highest = std::max(grid_.cubes_up_to() - support * grid_.h, 0.0);
  for (const SphereState& sphere : spheres)
    if (sphere.position.y() + sphere.radius > highest)
      throw UserError(
          fmt::format("{}: sphere {} reaches up to y = {:.6g}, but y is stretched and spheres need "
                      "cubic cells, "
                      "which here means y below {:.6g}; change 'grid.y_uniform'.",
                      settings_.file, sphere.tag, sphere.position.y() + sphere.radius, highest));
}

template <class Real>
void Channel<Real>::set_spheres(std::span<const SphereState> all) {
  if (all.empty() && !boundary_) return;
  check_height(all);
  if (!boundary_) {
    go_upwards();
    boundary_ = std::make_unique<ImmersedBoundary<Real>>(settings_, grid_, slabs_);
  }
  boundary_->set_spheres(all);
}

template <class Real>
void Channel<Real>::move_spheres(std::span<const SphereState> moved) {
  check_height(moved);
  if (!boundary_) {
    go_upwards();
    boundary_ = std::make_unique<ImmersedBoundary<Real>>(settings_, grid_, slabs_);
  }
  boundary_->move_spheres(moved);
}

/// When the first spheres come in mid-run.
template <class Real>
void Channel<Real>::go_upwards() {
  const bool turns = forth_ == Sweep::down;
  if (turns) {
    forth_ = Sweep::up;
    velocity_.relabel(-1);
    for (int j = slabs_.planes() - 1; j >= 0; --j)
      std::copy_n(velocity_.plane(j - 1), velocity_.plane_size(), velocity_.plane(j));
  }
  int any = turns ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm());
  if (!any) return;
  poisson_ = PoissonSolver<Real>(grid_, slabs_, pressure_component, forth_);
  const std::size_t components = diffusion_.size();
  diffusion_.clear();
  for (std::size_t c = 0; c < components; ++c)
    diffusion_.emplace_back(grid_, slabs_, static_cast<int>(c), forth_);
  fill_ghosts();
}

/// Ghosts within the own planes, from the own cells alone.
template <class Real>
void Channel<Real>::close_own_planes() {
  for (int j = 0; j < slabs_.planes(); ++j) {
    for (int k = 0; k < slabs_.rows(); ++k)
      for (int c = 0; c < 3; ++c) walls_.close_row(velocity_.row(j, k, c), c);
    walls_.close_plane(velocity_, j);
  }
}

template <class Real>
void Channel<Real>::finish_step() {
  time_ += dt_;
  dt_made_ = dt_;
  ++step_;
  set_driving(driving_this_step_);
  double sums[2] = {local_sum_, budget_.walls};
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, comm());
  fastest_ = local_fastest_;
  MPI_Allreduce(MPI_IN_PLACE, &fastest_, 1, MPI_DOUBLE, MPI_MAX, comm());
  streamwise_sum_ = sums[0];
  const double scale = fastest_ * grid_.cubes();
  const double residual = streamwise_sum_ - budget_.begin - budget_.given - sums[1];
  momentum_residual_ = scale > 0.0 ? residual / scale : residual;
  choose_time_step();
  check_field();
}

/// With time.cfl, the longest of the steps time.step 2^(-n/16), n = 0, 1, .., that keeps to it and
/// to the limit of explicit diffusion. Few lengths, so that what depends on the step is seldom made
/// anew; and a function of the present field alone, so that a run that is continued takes the same.
template <class Real>
void Channel<Real>::choose_time_step() {
  if (settings_.time.cfl == 0.0 || !std::isfinite(fastest_)) return;
  constexpr double lengths_per_octave = 16.0;
  const double longest = settings_.time.step;
  const double by_diffusion =
      implicit() ? longest : explicit_diffusion_limit(grid_, settings_.fluid.kinematic_viscosity);
  const double by_convection = fastest_ > 0.0 ? settings_.time.cfl * grid_.h / fastest_ : longest;
  const double wanted = std::min({longest, by_diffusion, by_convection});
  const double n = std::ceil(lengths_per_octave * std::log2(longest / wanted) - 1e-9);
  dt_ = longest * std::exp2(-n / lengths_per_octave);
}

/// Names the first value that is not finite.
template <class Real>
void Channel<Real>::report_not_finite() const {
  const BadPlace bad = find_not_finite(velocity_, slabs_);
  struct {
    int missing, rank;
  } first{bad.found ? 0 : 1, slabs_.rank()};
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
  if (!settings_.fluid.convection || cfl() <= imaginary_limit) return;
  const auto [i, j, k] = find_fastest(velocity_, grid_, slabs_);
  throw UserError(
      fmt::format("{}: step {} (t = {:.6g}): the CFL number is {:.3g} near cell ({}, {}, {}), but "
                  "the scheme is "
                  "stable only up to {:.3g}; set 'time.step' to at most {:.4g} (now {}).",
                  settings_.file, step_, time_, cfl(), i, j, k, imaginary_limit,
                  dt_ * imaginary_limit / cfl(), dt_));
}

template <class Real>
double Channel<Real>::max_divergence() const {
  return largest_divergence(velocity_, grid_, slabs_);
}

template <class Real>
double Channel<Real>::kinetic_energy() const {
  return settings_.fluid.density * kinetic_energy_integral(velocity_, grid_, slabs_);
}

template <class Real>
double Channel<Real>::viscous_loss() const {
  return settings_.fluid.density * settings_.fluid.kinematic_viscosity / (grid_.h * grid_.h) *
         viscous_loss_integral(velocity_, grid_, slabs_);
}

template <class Real>
std::array<double, 2> Channel<Real>::wall_stress() const {
  const double factor = settings_.fluid.density * settings_.fluid.kinematic_viscosity / grid_.h /
                        (double(grid_.cells[0]) * double(grid_.cells[2]));
  std::array<double, 2> stress{};
  const auto add = [&](std::size_t end, int ghost, int inner, double gap) {
    for (int k = 0; k < slabs_.rows(); ++k)
      stress[end] += factor / gap *
                     (row_sum(grid_.cells[0], velocity_.row(inner, k)) -
                      row_sum(grid_.cells[0], velocity_.row(ghost, k)));
  };
  if (slabs_.at_lower_wall()) add(0, -1, 0, grid_.gap(-1));
  if (slabs_.at_upper_wall())
    add(1, slabs_.planes(), slabs_.planes() - 1, grid_.gap(grid_.cells[1] - 1));
  MPI_Allreduce(MPI_IN_PLACE, stress.data(), 2, MPI_DOUBLE, MPI_SUM, comm());
  return stress;
}

template class Channel<float>;
template class Channel<double>;

}  // namespace bedload
