#pragma once

#include <mpi.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coupling/exchange/mailbox.hpp"
#include "coupling/exchange/message.hpp"
#include "coupling/exchange/routes.hpp"
#include "coupling/job/roles.hpp"
#include "coupling/job/run_script.hpp"

namespace bedload {

/// Loads of one stage as they arrived, for the spheres whose motion this rank sent last.
struct StageLoads {
  LoadHeader header{};
  std::vector<LoadRecord> loads;
};

/// LIGGGHTS' end of the exchange, free of LIGGGHTS itself. Collective over the LIGGGHTS ranks, each
/// of which hands in the spheres that it owns, none perhaps. Whoever waits sleeps.
class DemSide {
 public:
  explicit DemSide(const Job& job);

  /// The scene as the fluid describes it; waits for it the first time.
  const FluidSceneInfo& scene_info();

  /// The hand-shake, at the first coupled run: the scene as the script describes it (equal on every
  /// rank), its effects as text, and the spheres of this rank, fixed ones included. When the fluid
  /// disagrees it ends the job.
  void introduce(const DemSceneInfo& scene_info, const std::string& effects,
                 std::span<const StateRecord> spheres);
  bool introduced() const { return introduced_; }

  /// Waits for the fluid's division of the box and tells each of its ranks whether it is a partner.
  void find_partners(const Region& region);
  /// The checkpoint that the run goes on from: LIGGGHTS' half, and how many fluid steps were made
  /// then; empty and -1 for a run from its beginning. To be asked after scene_info().
  const std::string& restart_file() const { return restart_file_; }
  std::int64_t restart_step() const { return scene_info_ ? scene_info_->restart_step : -1; }
  /// What LIGGGHTS was started with; goes into checkpoints.
  void set_script(RunScript script) { script_ = std::move(script); }
  const RunScript& script() const { return script_; }
  /// Fluid steps that lie behind, of this run and of those that it goes on from.
  std::int64_t steps_made() const { return steps_made_; }
  void count_steps(std::int64_t made) { steps_made_ += made; }

  /// Waits for the next stage's loads. After a stop order the fluid sends nothing more.
  StageLoads receive_loads();

  /// Where to write LIGGGHTS' half of a checkpoint, after an order to do so.
  const std::string& checkpoint_file() const { return checkpoint_file_; }
  /// The number that both halves of that checkpoint carry.
  std::int64_t checkpoint_id() const { return checkpoint_id_; }
  /// Says that it is written.
  void confirm_checkpoint();

  /// Sends this rank's mobile spheres and what it did in the stage, to each partner those near its
  /// block; returns at once. Throws UserError when a sphere is near a block whose rank is no
  /// partner.
  void send_motion(MotionHeader header, std::span<const StateRecord> spheres);

  /// Whether the fluid has ended the coupled run.
  bool stopped() const { return stopped_; }
  /// How often the script has asked for steps since, this time included.
  int count_idle_run() { return ++idle_runs_; }

 private:
  const Job& job_;
  SendQueue send_queue_;
  std::optional<FluidSceneInfo> scene_info_;
  /// Of the last step that the fluid told of [T].
  double longest_stage_ = std::numeric_limits<double>::infinity();
  BlockMap blocks_;            ///< of the fluid
  std::vector<int> partners_;  ///< ranks of the fluid, ascending
  std::string restart_file_, checkpoint_file_;
  RunScript script_;
  std::int64_t checkpoint_id_ = 0, steps_made_ = 0;
  bool introduced_ = false;
  bool stopped_ = false;
  int idle_runs_ = 0;
};

}  // namespace bedload
