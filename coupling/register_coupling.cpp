#include "coupling/register_coupling.hpp"

#include "coupling/coupled_run.hpp"
#include "coupling/fix_couple_fluid.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/private_access.hpp"

namespace bedload {

void register_coupling(LAMMPS_NS::LAMMPS* lmp) {
  add_fix_style<FixCoupleFluid>(lmp, "couple/fluid");
  add_command(lmp, "coupled_run",
              [](LAMMPS_NS::LAMMPS* l, int narg, char** arg) { CoupledRun(l).command(narg, arg); });
}

std::string describe_coupling() {
  constexpr WordKeyword fixed[] = {
      {"fixed", "none: all are mobile",
       "Group of the spheres that never move; the fluid hears of them once."}};
  constexpr NumberKeyword steps[] = {{"steps", 0, false, no_limit, 0,
                                      "until the fluid's time is up", "fluid time steps",
                                      "How long this coupled run lasts."}};
  return describe_style({"fix couple/fluid",
                         "Puts the spheres of the group into the fluid of bedload-fluid.",
                         "fix ID group couple/fluid [fixed GROUP]",
                         {},
                         fixed}) +
         describe_style({"coupled_run",
                         "Takes the place of run: the grains move with the fluid.",
                         "coupled_run [steps N]",
                         steps,
                         {}});
}

}  // namespace bedload
