#pragma once

#include "pointers.h"

namespace bedload {

/// coupled_run [steps N]
///
/// Moves the grains with the fluid until the fluid's time is up, or for N fluid steps. It takes the
/// place of `run`: thermo, dump and every fix work as they do there, on LIGGGHTS' own steps, of
/// which a fluid step holds 15.
class CoupledRun : protected LAMMPS_NS::Pointers {
 public:
  explicit CoupledRun(LAMMPS_NS::LAMMPS* instance) : Pointers(instance) {}
  void command(int narg, char** arg);

 private:
  void prepare();
  void announce_last_step();
  void conclude();
};

}  // namespace bedload
