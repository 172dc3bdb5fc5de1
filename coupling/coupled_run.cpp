#include "coupling/coupled_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>

#include "coupling/fix_couple_fluid.hpp"
#include "coupling/stages.hpp"
#include "domain.h"
#include "finish.h"
#include "integrate.h"
#include "lammps.h"
#include "liggghts_styles/keywords.hpp"
#include "modify.h"
#include "output.h"
#include "timer.h"
#include "update.h"

namespace bedload {
namespace {

/// Number behind `steps`; without the keyword more steps than anybody makes.
std::int64_t read_steps(LAMMPS_NS::LAMMPS* instance, int narg, char** arg) {
  if (narg == 0) return std::numeric_limits<std::int64_t>::max();
  std::int64_t steps = 0;
  if (narg == 2 && std::string_view(arg[0]) == "steps") {
    const std::string_view text(arg[1]);
    const auto [end, error] = std::from_chars(text.begin(), text.end(), steps);
    if (error == std::errc{} && end == text.end() && steps > 0) return steps;
  }
  stop_run(instance,
           fmt::format("coupled_run: found '{}{}{}', allowed is nothing or 'steps N' with N > 0",
                       arg[0], narg > 1 ? " " : "", narg > 1 ? arg[1] : ""));
}

}  // namespace

void CoupledRun::command(int narg, char** arg) {
  if (domain->box_exist == 0) stop_run(lmp, "coupled_run stands before the simulation box is made");
  const std::int64_t most_steps = read_steps(lmp, narg, arg);
  auto* const fluid =
      static_cast<FixCoupleFluid*>(modify->find_fix_style_strict("couple/fluid", 0));
  if (fluid == nullptr)
    stop_run(lmp, "coupled_run needs a fix couple/fluid in the script before it");

  fluid->shake_hands();
  fluid->set_time_step(fluid->fluid_time_step());
  fluid->allow_run(true);
  prepare();

  bool going_on = true, first = true;
  for (std::int64_t step = 0; going_on && step < most_steps; ++step) {
    for (const int substeps : dem_substeps) {
      going_on = fluid->receive_loads(first);
      first = false;
      if (!going_on) break;
      if (fluid->stage().stage == 0) {
        fluid->set_time_step(fluid->stage().fluid_time_step);
        if (fluid->stage().last != 0 || step + 1 == most_steps) announce_last_step();
      }
      update->integrate->run(substeps);
      fluid->send_motion();
    }
  }

  conclude();
  fluid->allow_run(false);
}

// The beginning of LIGGGHTS' own `run`, with an end that is out of reach: nobody knows yet how many
// steps the fluid will make.
void CoupledRun::prepare() {
  update->whichflag = 1;
  update->nsteps = std::numeric_limits<int>::max();
  update->firststep = update->beginstep = update->ntimestep;
  update->laststep = update->endstep = update->firststep + update->nsteps;
  lmp->init();
  update->integrate->setup();
  timer->init();
  timer->barrier_start(TIME_LOOP);
}

// The fluid makes no step after this one: thermo prints a last line.
void CoupledRun::announce_last_step() {
  update->laststep = update->endstep = update->ntimestep + dem_substeps_per_step;
  output->next_thermo = std::min(output->next_thermo, update->laststep);
  output->next = std::min(output->next, output->next_thermo);
  modify->addstep_compute_all(output->next_thermo);
}

// The end of LIGGGHTS' own `run`.
void CoupledRun::conclude() {
  timer->barrier_stop(TIME_LOOP);
  update->nsteps = static_cast<int>(update->ntimestep - update->firststep);
  update->integrate->cleanup();
  LAMMPS_NS::Finish(lmp).end(1);
  update->whichflag = 0;
  update->firststep = update->laststep = 0;
  update->beginstep = update->endstep = 0;
}

}  // namespace bedload
