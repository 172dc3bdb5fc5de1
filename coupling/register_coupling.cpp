#include "coupling/register_coupling.hpp"

#include <map>
#include <string>

#include "coupling/coupled_run.hpp"
#include "coupling/fix_couple_fluid.hpp"
#include "input.h"
#include "lammps.h"
#include "liggghts_styles/private_access.hpp"

namespace bedload {
namespace {

// LIGGGHTS keeps its table of commands to itself and has no call to add to it. An explicit
// instantiation may name a protected member: `reach` hands the pointer to it out.
template <class Tag, typename Tag::Member member>
struct Reach {
  friend typename Tag::Member reach(Tag) { return member; }
};

struct CommandTable {
  using Creator = void (*)(LAMMPS_NS::LAMMPS*, int, char**);
  using Member = std::map<std::string, Creator>* LAMMPS_NS::Input::*;
  friend Member reach(CommandTable);
};
template struct Reach<CommandTable, &LAMMPS_NS::Input::command_map>;

}  // namespace

void register_coupling(LAMMPS_NS::LAMMPS* lmp) {
  add_fix_style<FixCoupleFluid>(lmp, "couple/fluid");
  (*(lmp->input->*reach(CommandTable{})))["coupled_run"] =
      [](LAMMPS_NS::LAMMPS* l, int narg, char** arg) { CoupledRun(l).command(narg, arg); };
}

}  // namespace bedload
