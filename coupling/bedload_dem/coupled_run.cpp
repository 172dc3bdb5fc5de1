#include "coupling/bedload_dem/coupled_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>

#include "atom.h"
#include "comm.h"
#include "coupling/bedload_dem/fix_couple_fluid.hpp"
#include "coupling/bedload_dem/restarted_dumps.hpp"
#include "coupling/bedload_dem/script_rules.hpp"
#include "coupling/bedload_dem/written_files.hpp"
#include "coupling/checkpoint/grains_state.hpp"
#include "coupling/exchange/stages.hpp"
#include "coupling/job/peer_failure.hpp"
#include "coupling/job/roles.hpp"
#include "domain.h"
#include "finish.h"
#include "fluid/checkpoint/checkpoint_store.hpp"
#include "fluid/settings/errors.hpp"
#include "force.h"
#include "integrate.h"
#include "lammps.h"
#include "liggghts_styles/contact_observers.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/lost_contacts.hpp"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "timer.h"
#include "update.h"

namespace bedload {
namespace {

/// Calls behind the fluid's end with which a script ends: one that loops until something has
/// happened would never.
constexpr int most_idle_runs = 10'000;

/// LIGGGHTS reads no further line of the file that it reads.
void end_script(LAMMPS_NS::LAMMPS* lmp) {
  if (lmp->comm->me != 0) return;
  std::fseek(lmp->infile, 0, SEEK_END);
  fmt::print(stderr,
             "\nbedload-dem: NOTE: the script has asked {} times for a coupled_run since the fluid "
             "has ended, and ends here; a loop that waits for something needs an end of its own.\n",
             most_idle_runs);
}

/// LIGGGHTS counts no further.
constexpr std::int64_t most_dem_steps = std::numeric_limits<int>::max();

/// Number behind `steps`; without the keyword more steps than anybody makes.
std::int64_t read_steps(LAMMPS_NS::LAMMPS* instance, int narg, char** arg) {
  const Arguments given(instance, CoupledRun::help, std::span(arg, static_cast<std::size_t>(narg)));
  return given.has("steps") ? static_cast<std::int64_t>(given.number("steps"))
                            : std::numeric_limits<std::int64_t>::max();
}

}  // namespace

// A UserError must not pass through LIGGGHTS, which would be taken down in the middle of a run.
void CoupledRun::command(int narg, char** arg) {
  try {
    run(narg, arg);
  } catch (const UserError& error) {
    stop_run(lmp, error.what());
  }
}

void CoupledRun::run(int narg, char** arg) {
  if (domain->box_exist == 0) stop_run(lmp, "coupled_run stands before the simulation box is made");
  const std::int64_t most_steps = read_steps(lmp, narg, arg);
  auto* const fluid =
      static_cast<FixCoupleFluid*>(modify->find_fix_style_strict("couple/fluid", 0));
  if (fluid == nullptr)
    stop_run(lmp, "coupled_run needs a fix couple/fluid in the script before it");

  fluid->note_script_atoms();
  DemSide& side = fluid->side();
  if (side.stopped()) {  // the fluid has ended in an earlier one and sends nothing more
    if (side.count_idle_run() >= most_idle_runs) end_script(lmp);
    return;
  }
  const std::int64_t behind = side.restart_step() - side.steps_made();
  if (most_steps <= behind) {  // this one was over when the checkpoint was written
    // As it did; some fixes are made then, in front of those of the lines that follow.
    fluid->set_time_step(fluid->fluid_time_step());
    lmp->init();
    side.count_steps(most_steps);
    return;
  }
  std::int64_t steps_left = most_steps;
  if (behind > 0) {
    steps_left -= behind;
    side.count_steps(behind);
  }

  if (!side.introduced())
    warn_of_counted_times(
        lmp, side.script(),
        DemSteps{side.scene_info().dem_steps}.time_step(fluid->fluid_time_step()));
  fluid->set_time_step(fluid->fluid_time_step());
  fluid->allow_run(true);
  refuse_clumps(lmp, "fix couple/fluid");
  refuse_neighbor_multi(lmp, "fix couple/fluid");
  compare_with_fluid(lmp);
  refuse_other_boxes(lmp);
  refuse_other_integrators(lmp);
  refuse_new_numbers(lmp);
  refuse_newton(lmp, "fix couple/fluid");
  fluid->check_before_run();
  warn_without_walls(lmp, fluid->names_fixed());
  warn_without_spin(lmp);
  warn_of_second_buoyancy(lmp);
  warn_of_stiff_contacts(lmp, fluid->fluid_time_step());
  warn_of_partly_held(lmp);
  warn_of_contacts_through_both_sides(lmp);
  prepare(*fluid, std::max<std::int64_t>(0, behind), most_steps);

  moved_ = true;
  for (; steps_left > 0 && make_step(*fluid, steps_left == 1); --steps_left) {
    side.count_steps(1);
    // Soon, so that no long run has been in vain; now and then, since insertions may come late.
    if (side.steps_made() % 100 == 1) fluid->check_fixed_during_run();
  }

  if (!side.stopped()) fluid->check_fixed_during_run();  // else it was looked at in the checkpoint
  conclude();
  fluid->allow_run(false);
}

// The sub-steps of one fluid step, stage by stage; false: the fluid makes no more. `last`: this run
// ends with it, even where the fluid's does not.
bool CoupledRun::make_step(FixCoupleFluid& fluid, bool last) {
  const DemSteps dem_steps{fluid.side().scene_info().dem_steps};
  bool begins = true;
  int left = dem_steps.per_step();
  for (const int substeps : dem_steps.in_stage) {
    if (substeps == 0) continue;
    if (!next_stage(fluid)) return false;
    if (begins) {
      fluid.set_time_step(fluid.stage().fluid_time_step);
      if (fluid.stage().last != 0 || last) announce_last_step(dem_steps.per_step());
    }
    begins = false;
    update->integrate->run(substeps);
    left -= substeps;
    fluid.send_motion(left == 0 && last);
  }
  fluid.check_inserted();
  old_lists_.look(fluid.fluid_time_step());
  if (const auto sentence = unwritten_file()) end_job(Program::dem, comm->me, *sentence + ".");
  return true;
}

// The beginning of LIGGGHTS' own `run`, with an end that is out of reach: it is not known yet how
// many steps the fluid will make.
// `behind`: fluid steps of this coupled_run that the run before has made.
void CoupledRun::prepare(FixCoupleFluid& fluid, std::int64_t behind, std::int64_t most_steps) {
  std::optional<GrainsState> start;
  if (!fluid.side().introduced() && fluid.side().restart_step() >= 0) {
    const std::string& file = fluid.side().restart_file();
    start.emplace(lmp, file, fluid.side().restart_step());
    name_checkpoint(std::filesystem::path(file).parent_path().string());
    start->compare(fluid.side().script(), fluid.made_by_script());
    start->refuse_moves_of_other_steps();
    start->let_insertions_pass();
    start->set_clock();
  } else {
    fluid.shake_hands();
  }
  // LIGGGHTS sorts its atoms into bins of half the range of pairs, of which there are none.
  if (force->pair == nullptr) atom->sortfreq = 0;
  update->whichflag = 1;
  update->nsteps = std::numeric_limits<int>::max();
  update->firststep = update->ntimestep;
  update->laststep = update->firststep + update->nsteps;
  set_span(fluid.side(), behind, most_steps);
  lmp->init();
  if (start) {
    start->set_clock();  // which the integrator has begun anew
    start->set_up_insertions();
    start->put_back();
    leave_out_step(*output, update->ntimestep);
    fluid.shake_hands();
  }
  update->integrate->setup();
  if (start) fluid.put_back_forces();
  fluid.renew_motion();
  timer->init();
  timer->barrier_start(TIME_LOOP);
}

// Over which steps `ramp()` and fixes that change something from the begin to the end of a run do
// so: where the end is not known, one that is out of reach.
void CoupledRun::set_span(DemSide& side, std::int64_t behind, std::int64_t most_steps) {
  const int per_step = DemSteps{side.scene_info().dem_steps}.per_step();
  const std::int64_t end_step = side.scene_info().end_step, before = side.steps_made() - behind;
  std::int64_t steps = most_steps;
  if (end_step >= 0) steps = std::min(steps, end_step - before);
  update->beginstep = update->firststep - behind * per_step;
  span_known_ = steps > 0 && steps < most_dem_steps / per_step;
  update->endstep = span_known_ ? update->beginstep + steps * per_step : update->laststep;
}

// Waits for the next stage, and writes checkpoints in the meantime; false: the run is over.
bool CoupledRun::next_stage(FixCoupleFluid& fluid) {
  std::optional<CheckpointPlace> written;
  Order order = fluid.receive_loads(moved_);
  for (; order == Order::checkpoint; order = fluid.receive_loads(moved_)) {
    write_checkpoint(fluid);
    const std::filesystem::path part = fluid.side().checkpoint_file();
    written = checkpoint_place(part.parent_path().parent_path().string(), fluid.stage().step);
  }
  // The next order tells that the fluid's half is on disk, too.
  if (written) name_checkpoint(written->folder);
  moved_ = false;
  return order == Order::advance;
}

// A run that starts from the checkpoint builds its lists anew, which changes the order in which a
// sphere's contact forces are added. The run that writes it does the same, so that both go on with
// the same digits.
void CoupledRun::write_checkpoint(FixCoupleFluid& fluid) {
  fluid.check_fixed_during_run();
  fluid.keep_forces();
  modify->setup_pre_exchange();
  update->update_time();  // the steps so far have this length, those of a restart maybe another
  const GrainsState state(lmp, fluid.stage().step, fluid.side().checkpoint_id(),
                          fluid.side().script(), fluid.made_by_script());
  state.write(fluid.side().checkpoint_file());
  fluid.side().confirm_checkpoint();
  state.align_random_numbers();
  rebuild_lists();
  fluid.put_back_forces();
  moved_ = true;
}

// What LIGGGHTS' own `run` begins with, without its output.
void CoupledRun::rebuild_lists() {
  atom->setup();
  domain->pbc();
  domain->reset_box();
  comm->setup();
  if (neighbor->style != 0) neighbor->setup_bins();
  comm->exchange();
  if (atom->sortfreq > 0) atom->sort();
  comm->borders();
  modify->setup_pre_neighbor();
  neighbor->build();
  update->integrate->setup_minimal(0);
}

// The fluid makes no step after this one: thermo prints a last line.
void CoupledRun::announce_last_step(int dem_steps) {
  update->laststep = update->ntimestep + dem_steps;
  if (!span_known_) update->endstep = update->laststep;
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
