#pragma once

#include <cstdint>

#include "coupling/bedload_dem/old_lists.hpp"
#include "liggghts_styles/keywords.hpp"
#include "pointers.h"

namespace bedload {

class DemSide;
class FixCoupleFluid;

/// coupled_run [steps N]
///
/// Moves the grains with the fluid until the fluid's time is up, or for N fluid steps. It takes the
/// place of `run`: thermo, dump and every fix work as they do there, on LIGGGHTS' own steps, of
/// which a fluid step holds coupling.dem_steps.
///
/// When the fluid goes on from a checkpoint, the coupled_runs of the script that were over by then
/// are passed over, and the one that was under way begins with the spheres of the checkpoint.
class CoupledRun : protected LAMMPS_NS::Pointers {
 public:
  static constexpr NumberKeyword keywords[] = {{"steps", 0, false, 1e15, 0,
                                                "until the fluid's time is up", "fluid time steps",
                                                "How long this coupled run lasts.", true}};
  static constexpr StyleHelp help{"coupled_run",
                                  "Takes the place of run: the grains move with the fluid.",
                                  "coupled_run [steps N]", keywords};

  explicit CoupledRun(LAMMPS_NS::LAMMPS* instance) : Pointers(instance), old_lists_(instance) {}
  void command(int narg, char** arg);

 private:
  void run(int narg, char** arg);
  void prepare(FixCoupleFluid& fluid, std::int64_t behind, std::int64_t most_steps);
  void set_span(DemSide& side, std::int64_t behind, std::int64_t most_steps);
  bool make_step(FixCoupleFluid& fluid, bool last);
  bool next_stage(FixCoupleFluid& fluid);
  void write_checkpoint(FixCoupleFluid& fluid);
  void rebuild_lists();
  void announce_last_step(int dem_steps);
  void conclude();

  OldLists old_lists_;
  bool span_known_ = false;  ///< the step at which this run ends
  bool moved_ = true;        ///< atoms may have changed rank since the last motion was sent
};

}  // namespace bedload
