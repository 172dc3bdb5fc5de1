#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "fluid/channel/driving.hpp"
#include "fluid/channel/fringe.hpp"
#include "fluid/channel/implicit_diffusion.hpp"
#include "fluid/channel/momentum_budget.hpp"
#include "fluid/channel/phase_clock.hpp"
#include "fluid/channel/predictor.hpp"
#include "fluid/channel/pressure_projection.hpp"
#include "fluid/channel/runge_kutta.hpp"
#include "fluid/channel/step_limits.hpp"
#include "fluid/channel/wall_ghosts.hpp"
#include "fluid/checkpoint/group.hpp"
#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field_list.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// Incompressible flow in a box, between walls or periodic in each direction, on a staggered grid
/// in slabs of y planes; fluid/README.md has the scheme. One time step is
///
///   for stage in 0..2:  predict(stage); force_spheres(stage); project(stage);
///   finish_step();
///
/// Planes that no marker reaches are predicted with project(), so that a flow without spheres takes
/// two sweeps over the memory. Every call but the plain accessors is collective over the
/// communicator; collective numbers are the same on every rank.
template <class Real>
class Channel {
 public:
  /// Makes the start field. `spheres` are handed to set_spheres(); without `cuts` they are all of
  /// the run and decide how the planes are divided over the ranks. Collective.
  /// Throws UserError for settings that contradict each other.
  Channel(const Settings& settings, MPI_Comm comm, std::span<const SphereState> spheres = {},
          const Cuts& cuts = {});
  ~Channel();

  /// All spheres that are near this rank's block, others may be among them; at the start and when
  /// some come or go. Collective.
  void set_spheres(std::span<const SphereState> spheres);
  /// The mobile spheres as they are now: all that are near this rank's block, others may be among
  /// them. `last_step` is the length of a step [T] by which they are weighed: of the one made last,
  /// which a restart knows, too.
  void move_spheres(std::span<const SphereState> moved, double last_step);

  /// Length of the step about to be made [T]: time.step, or what time.cfl allows.
  double time_step() const { return dt_; }
  /// Length of the step made last [T].
  double last_time_step() const { return dt_made_; }
  int next_stage() const { return next_stage_; }
  /// Momentum predictor u* of one Runge-Kutta stage, of the planes that markers reach, or of
  /// `all_planes` for who looks at u* or changes it; the others go with project().
  void predict(int stage, bool all_planes = false);
  /// Forces the fluid to the spheres' motion; returns the loads of the mobile spheres whose centre
  /// this rank holds.
  std::vector<SphereLoad> force_spheres(int stage);
  /// Makes the velocity divergence-free and sets the bulk velocity.
  void project(int stage);
  /// Ends the step: time, step number, numbers of the step. Throws UserError when the field is not
  /// finite or the next step would pass the scheme's limit.
  void finish_step();

  const Settings& settings() const { return settings_; }
  const Grid& grid() const { return grid_; }
  const Decomposition& decomposition() const { return decomposition_; }
  MPI_Comm comm() const { return decomposition_.comm(); }
  /// The flow (field_list.hpp).
  const FlowFields<Real>& fields() const { return fields_; }
  /// Velocity [L/T], all ghosts valid between steps. Component c lives on the upper c face of its
  /// cell (grid.hpp).
  const Field<Real>& velocity() const { return velocity_; }
  /// Kinematic pressure p/rho [L^2/T^2] at the cell centres, its level arbitrary, without the part
  /// that drives the flow; valid from the end of a step on, ghosts only where own values need them.
  const Field<Real>& pressure() const { return pressure_; }
  const ImmersedBoundary<Real>* immersed_boundary() const { return boundary_.get(); }
  /// Time that the stages have taken so far, by phase.
  const PhaseClock& clock() const { return clock_; }
  ImmersedBoundary<Real>* immersed_boundary() { return boundary_.get(); }
  /// Loops of the last stage's forcing, and what it did.
  int forcing_loops() const { return boundary_ ? boundary_->loops() : 0; }
  /// Collective.
  ForcingReport forcing() const { return boundary_ ? boundary_->report() : ForcingReport{}; }

  double time() const { return time_; }
  std::int64_t step() const { return step_; }
  /// Driving force per volume along x, mean over the last step [M/(L^2 T^2)].
  double driving_force() const { return settings_.fluid.density * driving_.acceleration(); }
  /// CFL number of the present field with the present step: largest (|u|+|v|+|w|) dt/h.
  double cfl() const { return fastest_ * dt_ / grid_.h; }
  /// Mean of u over the box [L/T].
  double bulk_velocity() const { return streamwise_sum_ / grid_.cubes(); }
  /// What the streamwise momentum of the box changed by in the last step beyond what driving, walls
  /// and spheres gave it, over the box's momentum scale: zero to round-off. Not followed between x
  /// walls, whose pressure would belong to it (NaN).
  double momentum_residual() const {
    return grid_.periodic(0) ? momentum_residual_ : std::numeric_limits<double>::quiet_NaN();
  }

  /// Computed on request. Collective.
  double max_divergence() const;  ///< [1/T]
  /// Slip of the projected velocity at the markers.
  Slip slip() { return boundary_ ? boundary_->slip(velocity_) : Slip{}; }
  double kinetic_energy() const;  ///< [M L^2/T^2]
  /// What viscosity takes from it, less what walls that slide give [M L^2/T^3].
  double viscous_loss() const;
  /// What walls that slide give [M L^2/T^3]; with viscous_loss() what viscosity turns into heat.
  double wall_power() const;
  /// Mean streamwise stress that the fluid exerts on the lower and on the upper wall [M/(L T^2)].
  std::array<double, 2> wall_stress() const;

  /// What round-off may make of it: of a sum over the box and, where diffusion is implicit, of the
  /// elimination of its mean, the more the longer the step.
  double momentum_rounding() const;

  /// Overwrites the velocity with value(component, position) at each component's own place, and
  /// projects it. Not shifted to the bulk velocity. Collective.
  void set_velocity(const std::function<double(int, const Vec3&)>& value);
  /// Restart: write own planes of the fields (read_state), then call restored(). The velocity is
  /// taken as it is, or projected where it comes from another grid. Collective.
  FlowFields<Real>& fields_to_restore() { return fields_; }
  void restored(double time, std::int64_t step, double driving_force, bool project_it);
  /// Before restored(), where a bulk velocity is kept: shifts u of own planes to it. A state that
  /// has another one is another start; no driving has to bring it there at once. Collective.
  void shift_to_bulk_velocity();
  /// What a run needs beside fields, time and step to go on with the same digits; to be loaded
  /// after restored().
  void save(const SaveGroup& group) const;
  void load(const LoadGroup& group);
  /// Takes ghosts from their owners as a restart does (the pressure's are else computed on both
  /// sides, equal to round-off), so that a run that is written down and one that goes on from there
  /// have the same digits. Collective.
  void renew_ghosts();

 private:
  double stage_step(int stage) const {
    return runge_kutta[static_cast<std::size_t>(stage)].two_alpha * dt_;
  }
  /// Spheres and implicit diffusion act between predictor and projection.
  bool keeps_old_pressure() const { return boundary_ != nullptr || diffusion_.on(); }
  int old_pressure_planes(bool all_planes) const;
  void begin_stage(int stage);
  template <class EachRow>
  void predict_planes(int first, int end, EachRow each_row);
  void diffuse(int stage);
  void predict_and_eliminate(int first, int stage);
  double bulk_shift(double step);
  void project_start_field();
  void measure_start();
  void choose_time_step();
  void check_field() const;
  [[noreturn]] void report_not_finite() const;

  Settings settings_;
  Grid grid_;
  Decomposition decomposition_;
  WallGhosts<Real> walls_;
  FlowFields<Real> fields_;
  Field<Real>&velocity_, &pressure_;  ///< of fields_
  Field<Real> tendency_;
  Predictor<Real> predictor_;
  ImplicitDiffusion<Real> diffusion_;
  PhaseClock clock_;
  PressureProjection<Real> projection_;
  Fringe<Real> fringe_;
  MeanDriving driving_;
  StepLimits limits_;
  MomentumBudget budget_;
  std::unique_ptr<ImmersedBoundary<Real>> boundary_;

  double dt_, dt_made_, time_ = 0.0;
  std::int64_t step_ = 0;
  int next_stage_ = 0;
  int old_pressure_planes_ = 0;  ///< own planes with the old pressure in the stage's predictor
  int predicted_ = 0;            ///< planes of u* that stand in the velocity before project()
  double streamwise_sum_ = 0.0;  ///< of u at the end of the last step, all ranks
  double fastest_ = 0.0;         ///< largest |u|+|v|+|w|, all ranks
  double momentum_residual_ = 0.0;
};

}  // namespace bedload
