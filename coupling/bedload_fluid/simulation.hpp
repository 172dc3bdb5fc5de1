#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "coupling/exchange/fluid_side.hpp"
#include "fluid/channel/channel.hpp"
#include "fluid/channel/energy_account.hpp"
#include "fluid/output/timing.hpp"
#include "fluid/validation/sphere_changes.hpp"
#include "fluid/validation/warnings.hpp"

namespace bedload {

/// Motion of the grains in LIGGGHTS behind one exchange, by the clock that both programs read [s].
struct GrainInterval {
  double began, ended;
};

/// The flow, its spheres and, where some of them move, LIGGGHTS at the other end of the exchange:
/// one time step of all of them.
template <class Real>
class Simulation {
 public:
  /// `partner` is nullptr without LIGGGHTS; `spheres` are at least those near this rank's block
  /// under the division `cuts`, or all where that is empty; without LIGGGHTS fixed ones.
  /// Collective.
  Simulation(const Settings& settings, MPI_Comm comm, FluidSide* partner,
             std::span<const SphereState> spheres, const Cuts& cuts = {});

  /// When the flow stands, restored or at its start: places the mobile spheres where the coming
  /// stage, of a length that is known now, finds them at its end. Collective.
  void place_for_first_stage();
  /// Takes over what LIGGGHTS' script has changed between two coupled runs, where something is due:
  /// done at the begin of a step, and to be done before a checkpoint, of which LIGGGHTS' half knows
  /// of it. Collective.
  void renew_spheres();
  /// One time step; `last`: none follows. Collective.
  void make_step(bool last);

  Channel<Real>& channel() { return channel_; }
  const Channel<Real>& channel() const { return channel_; }
  Timing& timing() { return timing_; }
  /// Wall clock that LIGGGHTS has spent on the grains' motion so far, as this rank's partners say
  /// [s].
  double grain_seconds() const { return grain_seconds_; }
  /// What LIGGGHTS did in the last step.
  const std::vector<GrainInterval>& grain_intervals() const { return grain_intervals_; }

  /// Those near this rank's block.
  const std::vector<SphereState>& spheres() const { return spheres_; }
  /// Whether there have been spheres at its begin, or a partner who may insert some; the same on
  /// every rank.
  bool may_have_spheres() const { return may_have_spheres_; }
  bool may_have_mobile_spheres() const { return partner_ != nullptr; }
  /// The mobile, or fixed, spheres whose centre lies in this rank's block.
  std::vector<SphereState> mobile_here() const { return here(true); }
  std::vector<SphereState> fixed_here() const { return here(false); }
  /// This rank's part of force and torque on mobile spheres, mean over the last step: a sphere that
  /// changed rank in mid-step has its stages in two places, which are to be added up.
  std::vector<SphereLoad> mean_loads() const;
  /// What is hardest among all mobile spheres. Collective.
  SphereExtremes extremes() const;
  /// This rank's part of the fluid's force on fixed spheres, mean over the last step, buoyancy
  /// included: parts of a sphere are to be added up. Without what the fluid inside gains in
  /// momentum, whose mean over time is nothing.
  std::vector<SphereLoad> fixed_loads() const;
  /// Their sum, which takes three numbers in a message however many spheres there are. Collective.
  Vec3 fixed_force() const;
  /// Of mobile spheres on walls below and above them along x, by contacts and films, over the area
  /// of a y wall, mean over the last step.
  std::array<double, 2> grain_stress() const;
  std::int64_t mobile_count() const { return account_.mobile; }
  /// Whether mobile spheres came, went or became others in the last step; the same on every rank.
  bool spheres_changed() const { return spheres_changed_; }
  /// Of the last step: the larger of what the fluid's streamwise momentum and what the exchange
  /// with LIGGGHTS fails to balance by, each over its own size. Between x walls the fluid's is not
  /// followed: that of the exchange alone, or NaN.
  double momentum_residual() const;
  /// Of the last step; not followed (NaN) unless output.energy_work asks for it.
  EnergyWork energy_work() const { return energy_ ? energy_->work() : EnergyWork{}; }
  /// Finished collisions so far; -1: they are not counted.
  std::int64_t collisions() const { return account_.collisions; }

 private:
  std::vector<SphereState> here(bool mobile) const;
  void count_spheres();
  /// Of the fluid on a fixed sphere at rest.
  Vec3 buoyancy(const SphereState& sphere) const;
  void begin_step();
  void end_stage(int stage);
  void move_spheres(double dt);
  void place_spheres(double dt);
  void check_loads() const;
  void check_momentum() const;
  void add_to_mean(int stage);
  std::vector<SphereLoad> loads_to_send() const;
  void take_note();

  Channel<Real> channel_;
  FluidSide* partner_;
  Timing timing_;
  /// In the order of a stage, so that the table reads like the time step.
  struct Phases {
    Phases(Timing& timing, bool spheres, bool coupled);
    std::size_t flow = 0, predictor = 0, markers = 0, exchange = 0, pressure = 0, waiting = 0,
                closing = 0;
  } phases_;
  std::vector<GrainInterval> grain_intervals_;
  std::vector<SphereState> spheres_;
  std::vector<SphereLoad> loads_;                  ///< of the present stage, of spheres here
  Motion motion_;                                  ///< what LIGGGHTS answered
  std::map<std::int64_t, SphereLoad> mean_loads_;  ///< by tag, of the last step so far
  std::vector<SphereLoad> fixed_impulses_;         ///< on the fluid in the last step, this rank's
  double grain_seconds_ = 0.0;
  StepAccount account_;
  SphereChanges changes_;
  bool spheres_changed_ = false;
  bool may_have_spheres_ = false;
  bool has_fixed_ = false;                       ///< on some rank
  Vec3 buoyancy_of_fixed_ = Vec3::Zero();        ///< on all of them
  std::unique_ptr<EnergyAccount<Real>> energy_;  ///< where it is asked for
};

}  // namespace bedload
