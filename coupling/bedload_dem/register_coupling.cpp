#include "coupling/bedload_dem/register_coupling.hpp"

#include "coupling/bedload_dem/coupled_run.hpp"
#include "coupling/bedload_dem/fix_couple_fluid.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/private_access.hpp"

namespace bedload {

void register_coupling(LAMMPS_NS::LAMMPS* lmp) {
  add_fix_style<FixCoupleFluid>(lmp, "couple/fluid");
  add_command(lmp, "coupled_run",
              [](LAMMPS_NS::LAMMPS* l, int narg, char** arg) { CoupledRun(l).command(narg, arg); });
}

std::vector<StyleHelp> coupling_styles() { return {FixCoupleFluid::help, CoupledRun::help}; }

}  // namespace bedload
