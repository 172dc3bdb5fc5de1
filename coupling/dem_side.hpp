#pragma once

#include <mpi.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coupling/mailbox.hpp"
#include "coupling/message.hpp"
#include "coupling/roles.hpp"
#include "coupling/routes.hpp"

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

  /// What the fluid said of the scene; waits for it the first time.
  const FluidFacts& facts();

  /// The hand-shake, at the first coupled run: what the script says (equal on every rank), its
  /// effects as text, and the spheres of this rank, fixed ones included. When the fluid disagrees
  /// it ends the job.
  void introduce(const DemFacts& facts, const std::string& effects,
                 std::span<const StateRecord> spheres);
  bool introduced() const { return introduced_; }

  /// Waits for the fluid's division of the box and tells each of its ranks whether it is a partner.
  void find_partners(const Region& region);

  /// Waits for the next stage's loads. After a stop order the fluid sends nothing more.
  StageLoads receive_loads();

  /// Sends this rank's mobile spheres and what it did in the stage, to each partner those near its
  /// block; returns at once. Throws UserError when a sphere is near a block whose rank is no
  /// partner.
  void send_motion(MotionHeader header, std::span<const StateRecord> spheres);

  /// Whether the fluid has ended the coupled run.
  bool stopped() const { return stopped_; }

 private:
  const Job& job_;
  Outbox outbox_;
  std::optional<FluidFacts> facts_;
  BlockMap blocks_;            ///< of the fluid
  std::vector<int> partners_;  ///< ranks of the fluid, ascending
  bool introduced_ = false;
  bool stopped_ = false;
};

}  // namespace bedload
