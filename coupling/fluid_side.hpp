#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "coupling/mailbox.hpp"
#include "coupling/message.hpp"
#include "coupling/roles.hpp"
#include "coupling/stages.hpp"
#include "fluid/block_map.hpp"
#include "fluid/sphere.hpp"

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
  std::int64_t collisions = -1;  ///< finished so far in the whole run; -1: nobody counts
  std::int64_t mobile = 0;       ///< mobile spheres now
};

/// What the hand-shake brought.
struct Acquaintance {
  DemFacts facts{};
  std::vector<SphereState> spheres;  ///< fixed and mobile, ascending tags
  std::string effects;               ///< one line per effect of the LIGGGHTS script
};

/// The fluid's end of the exchange. Each rank receives the spheres near its block and sends the
/// loads of those whose centre lies in it. Collective over the fluid's ranks; whoever waits sleeps.
class FluidSide {
 public:
  explicit FluidSide(const Job& job);

  /// Tells LIGGGHTS about the scene; returns at once. To be called as soon as it is known, because
  /// fix couple/fluid waits for it.
  /// `grains`: where LIGGGHTS finds its half of the checkpoint that the run goes on from.
  void introduce(const FluidFacts& facts, const std::string& grains = {});

  /// Waits until the LIGGGHTS script has come to coupled_run, compares the two programs' scenes.
  /// Throws UserError with both values where they disagree.
  Acquaintance meet();

  /// Tells LIGGGHTS how the box is divided, and learns which of its ranks are partners.
  void divide(const BlockMap& blocks);

  /// LIGGGHTS' steps by stage; one without steps sends no loads.
  DemSteps dem_steps() const { return {facts_.dem_steps}; }

  /// Sends the loads of `stage` and returns while LIGGGHTS begins to move the spheres.
  /// `last_step`: the fluid makes no step after this one.
  void send_loads(int stage, double time_step, bool last_step, std::span<const SphereLoad> loads);

  /// Waits for the spheres' motion at the end of the stage.
  Motion receive_motion();

  /// Adds up the step that the last stage has ended.
  StepAccount settle();

  /// Between two steps: has LIGGGHTS write its half of a checkpoint; returns at once.
  void order_checkpoint(const std::string& grains);
  /// Waits until it is written.
  void await_checkpoint();

  /// Ends the coupled run; LIGGGHTS goes on with the line after coupled_run.
  void stop();

 private:
  /// Force and torque over time of one stage: sent by this rank; given, or lost with a
  /// sphere that is gone, as its partners say.
  struct StageSums {
    Triple sent{}, angular_sent{}, given{}, angular_given{};
    double size = 0.0, angular_size = 0.0;
  };
  void post_loads(const LoadHeader& header, std::span<const SphereLoad> loads);
  void remember_owners(const std::vector<StateRecord>& records, int dem);

  const Job& job_;
  Outbox outbox_;
  FluidFacts facts_{};
  BlockMap blocks_;
  std::vector<int> partners_;                     ///< ranks of LIGGGHTS, ascending
  std::unordered_map<std::int64_t, int> owners_;  ///< rank of LIGGGHTS by tag, of spheres here
  std::int64_t step_ = 0;
  int stage_ = 0;
  std::array<StageSums, 3> sums_{};
  std::int64_t collisions_ = 0, mobile_ = 0;  ///< this rank's share
};

}  // namespace bedload
