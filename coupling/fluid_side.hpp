#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "coupling/mailbox.hpp"
#include "coupling/message.hpp"
#include "coupling/roles.hpp"
#include "fluid/sphere.hpp"

namespace bedload {

/// What LIGGGHTS sent back at the end of one stage.
struct Motion {
  std::vector<SphereState> mobile;  ///< all mobile spheres, ascending tags
  bool same_spheres = true;         ///< false: some came or went since the last stage
  double momentum_residual = 0.0;   ///< see FluidSide::receive_motion
  std::int64_t collisions = -1;     ///< finished so far in the whole run; -1: nobody counts
  double dem_began = 0.0;           ///< clock [s] at which the first LIGGGHTS rank set off
  double dem_ended = 0.0;           ///< and at which the last one was done
};

/// What the hand-shake brought.
struct Acquaintance {
  DemFacts facts{};
  std::vector<SphereState> spheres;  ///< fixed and mobile, ascending tags
  std::string effects;               ///< one line per effect of the LIGGGHTS script
};

/// The fluid's end of the exchange. Collective over the fluid's ranks; each rank holds the same
/// spheres and hands in the same, complete loads. Whoever waits sleeps.
class FluidSide {
 public:
  explicit FluidSide(const Job& job);

  /// Tells LIGGGHTS about the scene; returns at once. To be called as soon as it is known, because
  /// fix couple/fluid waits for it.
  void introduce(const FluidFacts& facts);

  /// Waits until the LIGGGHTS script has come to coupled_run, compares the two programs' scenes.
  /// Throws UserError with both values where they disagree.
  Acquaintance meet();

  /// Sends the loads of `stage` and returns while LIGGGHTS begins to move the spheres.
  /// `last_step`: the fluid makes no step after this one.
  void send_loads(int stage, double time_step, bool last_step, std::span<const SphereLoad> loads);

  /// Waits for the spheres' motion at the end of the stage. The momentum residual compares the
  /// impulse of the loads sent with the one that LIGGGHTS added to its atoms, sub-step by sub-step,
  /// over all ranks, force and torque: largest difference of a component over the sum of the
  /// single loads' sizes.
  Motion receive_motion();

  /// Ends the coupled run; LIGGGHTS goes on with the line after coupled_run.
  void stop();

 private:
  std::vector<SphereState> gather_states(Subject subject, std::vector<MotionHeader>& headers) const;
  void post_loads(const LoadHeader& header, std::span<const LoadRecord> records);

  const Job& job_;
  Outbox outbox_;
  FluidFacts facts_{};
  std::int64_t step_ = 0;
  int stage_ = 0;
  std::vector<std::int64_t> mobile_tags_;
  Triple impulse_sent_{}, angular_impulse_sent_{};
  double impulse_size_ = 0.0, angular_impulse_size_ = 0.0;
};

}  // namespace bedload
