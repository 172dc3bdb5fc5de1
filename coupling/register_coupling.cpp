#include "coupling/register_coupling.hpp"

#include <map>
#include <string>

#include "coupling/coupled_run.hpp"
#include "coupling/fix_couple_fluid.hpp"
#include "input.h"
#include "lammps.h"
#include "modify.h"

namespace bedload {
namespace {

// LIGGGHTS keeps its tables of styles private and has no call to add to them. An explicit
// instantiation may name a private member: `reach` hands the pointer to it out.
template <class Tag, typename Tag::Member member>
struct Reach {
  friend typename Tag::Member reach(Tag) { return member; }
};

struct FixTable {
  using Creator = LAMMPS_NS::Fix* (*)(LAMMPS_NS::LAMMPS*, int, char**);
  using Member = std::map<std::string, Creator>* LAMMPS_NS::Modify::*;
  friend Member reach(FixTable);
};
template struct Reach<FixTable, &LAMMPS_NS::Modify::fix_map>;

struct CommandTable {
  using Creator = void (*)(LAMMPS_NS::LAMMPS*, int, char**);
  using Member = std::map<std::string, Creator>* LAMMPS_NS::Input::*;
  friend Member reach(CommandTable);
};
template struct Reach<CommandTable, &LAMMPS_NS::Input::command_map>;

}  // namespace

void register_coupling(LAMMPS_NS::LAMMPS* lmp) {
  (*(lmp->modify->*reach(FixTable{})))["couple/fluid"] = [](LAMMPS_NS::LAMMPS* l, int narg,
                                                            char** arg) -> LAMMPS_NS::Fix* {
    return new FixCoupleFluid(l, narg, arg);
  };
  (*(lmp->input->*reach(CommandTable{})))["coupled_run"] =
      [](LAMMPS_NS::LAMMPS* l, int narg, char** arg) { CoupledRun(l).command(narg, arg); };
}

}  // namespace bedload
