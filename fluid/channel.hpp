#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "fluid/decomposition.hpp"
#include "fluid/field.hpp"
#include "fluid/fringe.hpp"
#include "fluid/grid.hpp"
#include "fluid/phase_clock.hpp"
#include "fluid/poisson.hpp"
#include "fluid/predictor.hpp"
#include "fluid/runge_kutta.hpp"
#include "fluid/settings.hpp"
#include "fluid/sphere.hpp"
#include "fluid/spheres/immersed_boundary.hpp"
#include "fluid/sweep.hpp"
#include "fluid/wall_ghosts.hpp"

namespace bedload {

/// Incompressible flow in a box, between walls or periodic in each direction, on a staggered grid
/// in slabs of y planes; README.md has the scheme. One time step is
///
///   for stage in 0..2:  predict(stage); force_spheres(stage); project(stage);
///   finish_step();
///
/// or, without spheres, advance_stage(stage) in place of the three: the same numbers in two sweeps
/// over the memory instead of three. Every call but the plain accessors is collective over the
/// communicator; collective numbers are the same on every rank.
template <class Real>
class Channel {
 public:
  /// Makes the start field. `spheres` decide how the planes are divided over the ranks and are
  /// handed to set_spheres(); a run that goes on from another one gives that one's `cuts` instead.
  /// Throws UserError for settings that contradict each other.
  Channel(const Settings& settings, MPI_Comm comm, std::span<const SphereState> spheres = {},
          const Cuts& cuts = {});
  ~Channel();

  /// All spheres of the run, the same list on every rank; at the start and when some come or go.
  void set_spheres(std::span<const SphereState> all);
  /// The mobile spheres as they are now: all that are near this rank's block, others may be among
  /// them.
  void move_spheres(std::span<const SphereState> moved);

  /// Length of the step about to be made [T]: time.step, or what time.cfl allows.
  double time_step() const { return dt_; }
  /// Length of the step made last [T].
  double last_time_step() const { return dt_made_; }
  /// Explicit momentum predictor u* of one Runge-Kutta stage; with spheres only of the planes that
  /// their markers reach, the others go with project().
  void predict(int stage);
  /// Forces the fluid to the spheres' motion; returns the loads of the mobile spheres whose centre
  /// this rank holds.
  std::vector<SphereLoad> force_spheres(int stage);
  /// Makes the velocity divergence-free and sets the bulk velocity.
  void project(int stage);
  /// predict and project in one, when there are no spheres.
  void advance_stage(int stage);
  /// Ends the step: time, step number, numbers of the step. Throws UserError when the field is not
  /// finite or the next step would pass the scheme's limit.
  void finish_step();

  const Settings& settings() const { return settings_; }
  const Grid& grid() const { return grid_; }
  const Decomposition& decomposition() const { return slabs_; }
  MPI_Comm comm() const { return slabs_.comm(); }
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
  double driving_force() const { return settings_.fluid.density * driving_; }
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
  /// What viscosity takes from it [M L^2/T^3].
  double viscous_loss() const;
  /// Mean streamwise stress that the fluid exerts on the lower and on the upper wall [M/(L T^2)].
  std::array<double, 2> wall_stress() const;

  /// Overwrites the velocity with value(component, position) at each component's own place, and
  /// projects it. Not shifted to the bulk velocity. Collective.
  void set_velocity(const std::function<double(int, const Vec3&)>& value);
  /// Restart: write own planes of velocity and pressure, then call restored(). The velocity is
  /// taken as it is, or projected where it comes from another grid. Collective.
  Field<Real>& velocity_to_restore() { return velocity_; }
  Field<Real>& pressure_to_restore() { return pressure_; }
  void restored(double time, std::int64_t step, double driving_force, bool project_it);
  /// What a run needs beside fields, time and step to go on with the same digits; to be handed in
  /// after restored().
  std::vector<double> running_numbers() const;
  /// Takes ghosts from their owners as a restart does (the pressure's are else computed on both
  /// sides, equal to round-off), so that a run that is written down and one that goes on from there
  /// have the same digits. Collective.
  void renew_ghosts();
  void set_running_numbers(std::span<const double> numbers);

 private:
  /// What one step adds to the streamwise sum of the velocity, in that sum's unit [L/T].
  struct MomentumBudget {
    double begin = 0.0;       ///< sum at the begin of the step, all ranks
    double given = 0.0;       ///< by driving, all ranks
    double walls = 0.0;       ///< by wall stress, fringe and spheres, this rank's share
    double walls_last = 0.0;  ///< wall term of the tendency of the stage before, this rank's share
  };

  enum class PressureUse { none, add, replace };
  struct Correction {
    double step;           ///< length of the stage [T]
    double shift;          ///< added to u [L/T]
    bool measure;          ///< whether sum and largest speed are taken
    int moved;             ///< planes that u* lies below its place
    PressureUse pressure;  ///< what becomes of phi
  };

  void check_settings() const;
  void check_height(std::span<const SphereState> spheres) const;
  double stage_step(int stage) const {
    return runge_kutta[static_cast<std::size_t>(stage)].two_alpha * dt_;
  }
  /// Spheres and implicit diffusion act between predictor and projection.
  bool keeps_old_pressure() const { return boundary_ != nullptr || implicit(); }
  bool implicit() const { return !diffusion_.empty(); }
  void diffuse(int stage);
  void begin_stage(int stage);
  /// What the elimination takes of one plane: div u*, row by row, and the sum of u*.
  struct Outflow {
    int j, at;             ///< plane, and the one in whose storage its u* is
    bool waits_for_below;  ///< v* of the plane below is taken on its own
    double thickness;
    Real in_plane, upwards;  ///< areas over h^2, times h/(stage's length)
    double sum = 0.0;
  };
  template <class EachRow>
  void predict_plane(int j, EachRow each_row);
  void go_upwards();
  void close_wall_face(int j, int k);
  void predict_and_eliminate(int first, int stage);
  Outflow outflow(int j, int moved, double step) const;
  void take_row(Outflow& flow, int k);
  void take_row_below(const Outflow& flow, int k);
  void eliminate_plane(const Outflow& flow);
  void eliminate_plane(int j, int moved, double step);
  void couple_and_correct(int stage);
  double bulk_shift(double step);
  void substitute_and_correct(const Correction& correction);
  void substitute_to_correct(int j, PressureUse pressure);
  void correct_plane(int j, const Correction& correction);
  void update_pressure(int j, PressureUse use);
  void close_own_planes();
  void fill_ghosts();
  void project_start_field();
  double local_wall_sum() const;
  void measure_start();
  void choose_time_step();
  void check_field() const;
  [[noreturn]] void report_not_finite() const;

  Settings settings_;
  Grid grid_;
  Decomposition slabs_;
  WallGhosts<Real> walls_;
  Field<Real> velocity_, tendency_, pressure_;
  Predictor<Real> predictor_;
  Sweep forth_;  ///< direction of predictor and elimination; correction goes the other way
  PoissonSolver<Real> poisson_;
  std::vector<PoissonSolver<Real>> diffusion_;  ///< of u, v, w; none where diffusion is explicit
  Fringe<Real> fringe_;
  std::vector<Real> zeros_;
  std::unique_ptr<ImmersedBoundary<Real>> boundary_;
  PhaseClock clock_;

  double dt_, dt_made_, time_ = 0.0;
  std::int64_t step_ = 0;
  /// Sets driving_: as the settings give it, or, where a bulk velocity is kept, to what was `found`
  /// to keep it in the last step (also of another run, whose state this one goes on from).
  void set_driving(double found);

  double driving_ = 0.0;            ///< acceleration along x, mean of the last step
  double driving_predicted_ = 0.0;  ///< the part that the predictor has given already
  double driving_this_step_ = 0.0;
  int predicted_ = 0;            ///< planes of u* that stand in the velocity before project()
  double local_sum_ = 0.0;       ///< of u*, then of u, over this rank's planes
  double streamwise_sum_ = 0.0;  ///< of u at the end of the last step, all ranks
  double fastest_ = 0.0;         ///< largest |u|+|v|+|w|, all ranks
  double local_fastest_ = 0.0;
  MomentumBudget budget_;
  double momentum_residual_ = 0.0;
};

}  // namespace bedload
