#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "coupling/exchange/mailbox.hpp"
#include "coupling/exchange/message.hpp"
#include "coupling/exchange/stages.hpp"
#include "coupling/job/roles.hpp"
#include "fluid/grid/block_map.hpp"
#include "fluid/grid/sphere.hpp"

namespace bedload {

/// What LIGGGHTS sent back at the end of one stage.
struct Motion {
  std::vector<SphereState> mobile;  ///< all mobile spheres near this rank's block, ascending tags
  double dem_began = 0.0;           ///< clock [s] at which the first of the partners set off
  double dem_ended = 0.0;           ///< and at which the last one was done
};

/// What the exchange of one step comes to, over all ranks.
struct StepAccount {
  /// Impulse of the loads sent against the one that LIGGGHTS added to its atoms, sub-step by
  /// sub-step, or could not add because it had deleted them, force and torque: largest difference
  /// of a component over the sum of the single loads' sizes, the worst of the stages.
  double momentum_residual = 0.0;
  std::int64_t collisions = -1;  ///< finished so far in the whole run; -1: they are not counted
  std::int64_t mobile = 0;       ///< mobile spheres now
  double kinds = 0.0;            ///< kinds_of() the mobile spheres now
  /// That the spheres gave along x to walls below and above them, by contacts and films [M L/T].
  std::array<double, 2> on_walls{};
};

/// A whole number that changes when one of the mobile spheres comes, goes, or gets another size or
/// density: the sum of a number of 32 bits for each.
double kinds_of(std::span<const SphereState> spheres);

/// What the hand-shake brought.
struct PartnerScene {
  DemSceneInfo scene_info{};
  std::vector<SphereState> told;  ///< those that this rank alone was told of, ascending tags
  std::string effects;            ///< one line per effect of the LIGGGHTS script
};

/// The fluid's end of the exchange. Each rank receives the spheres near its block and sends the
/// loads of those whose centre lies in it. Collective over the fluid's ranks; whoever waits sleeps.
class FluidSide {
 public:
  explicit FluidSide(const Job& job);

  /// Tells LIGGGHTS about the scene; returns at once. To be called as soon as it is known, because
  /// fix couple/fluid waits for it.
  /// `grains`: where LIGGGHTS finds its half of the checkpoint that the run goes on from.
  void introduce(const FluidSceneInfo& scene_info, const std::string& grains = {});

  /// Waits until the LIGGGHTS script has come to coupled_run, compares the two programs' scenes.
  /// Throws UserError with both values where they disagree.
  PartnerScene meet();

  /// Hands on the spheres that meet() brought, so that each rank knows those near its block, fixed
  /// and mobile, ascending tags. Throws UserError where two have the same tag.
  std::vector<SphereState> share_out(const BlockMap& blocks);

  /// Tells LIGGGHTS how the box is divided, and learns which of its ranks are partners.
  void divide(const BlockMap& blocks);

  /// LIGGGHTS' steps by stage; one without steps sends no loads.
  DemSteps dem_steps() const { return {scene_info_.dem_steps}; }

  /// Sends the loads of `stage` and returns while LIGGGHTS begins to move the spheres.
  /// `last_step`: the fluid makes no step after this one.
  void send_loads(int stage, double time_step, bool last_step, std::span<const SphereLoad> loads);

  /// Waits for the spheres' motion at the end of the stage.
  Motion receive_motion();

  /// Whether the last motion ended a coupled run that another one follows: the script may change
  /// spheres in between, and their motion comes once more.
  bool renewal_due() const { return renewal_due_; }
  /// Waits for that, to be called between two steps; ascending tags.
  std::vector<SphereState> receive_renewed();

  /// Adds up the step that the last stage has ended.
  StepAccount settle();

  /// Between two steps: has LIGGGHTS write its half of the checkpoint with the number `id`; returns
  /// at once.
  void order_checkpoint(const std::string& grains, std::int64_t id);
  /// Waits until it is written.
  void await_checkpoint();

  /// Ends the coupled run; LIGGGHTS goes on with the line after coupled_run.
  void stop();

 private:
  /// Force and torque over time of one stage: sent by this rank; given, or lost with a
  /// sphere that is gone, as its partners say.
  struct StageSums {
    Triple sent{}, angular_sent{}, given{}, angular_given{};
    std::array<double, 2> on_walls{};  ///< StepAccount::on_walls
    double size = 0.0, angular_size = 0.0;
  };
  void post_loads(const LoadHeader& header, std::span<const SphereLoad> loads);
  void remember_owners(const std::vector<StateRecord>& records, int dem);
  /// A sphere and the rank of LIGGGHTS that has it.
  struct OwnedSphere {
    std::int64_t owner;
    StateRecord record;
  };

  const Job& job_;
  SendQueue send_queue_;
  FluidSceneInfo scene_info_{};
  BlockMap blocks_;
  std::vector<OwnedSphere> told_;                 ///< between meet() and share_out()
  std::vector<int> partners_;                     ///< ranks of LIGGGHTS, ascending
  std::unordered_map<std::int64_t, int> owners_;  ///< rank of LIGGGHTS by tag, of spheres here
  std::int64_t step_ = 0;
  bool renewal_due_ = false;
  int stage_ = 0;
  std::array<StageSums, 3> sums_{};
  std::int64_t collisions_ = 0, mobile_ = 0;  ///< this rank's share
  double kinds_ = 0.0;
};

}  // namespace bedload
