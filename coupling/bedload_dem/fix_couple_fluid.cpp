#include "coupling/bedload_dem/fix_couple_fluid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "coupling/bedload_dem/attach.hpp"
#include "coupling/bedload_dem/over_ranks.hpp"
#include "coupling/bedload_dem/overlaps.hpp"
#include "coupling/bedload_dem/projected_loads.hpp"
#include "coupling/bedload_dem/restarted_dumps.hpp"
#include "coupling/bedload_dem/scene_description.hpp"
#include "coupling/bedload_dem/script_rules.hpp"
#include "coupling/exchange/clock.hpp"
#include "coupling/exchange/stages.hpp"
#include "coupling/job/roles.hpp"
#include "domain.h"
#include "fix_property_atom.h"
#include "fluid/settings/errors.hpp"
#include "fluid/validation/validate.hpp"
#include "force.h"
#include "group.h"
#include "integrate.h"
#include "lammps.h"
#include "liggghts_styles/find_fix.hpp"
#include "liggghts_styles/fix_lubrication.hpp"
#include "liggghts_styles/fix_marker_film.hpp"
#include "liggghts_styles/hand_on.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/mobility.hpp"
#include "liggghts_styles/owned_atom.hpp"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "pair.h"
#include "update.h"

namespace bedload {
namespace {

constexpr const char* force_name = "couple_force";
constexpr const char* torque_name = "couple_torque";
constexpr const char* kept_name = "couple_kept";
constexpr const char* overlap_name = "couple_overlap";
constexpr const char* film_name = "couple_film";
constexpr const char* marker_film_name = "couple_marker_film";  // the fix that finds those loads

FluidEnd::Kind kind_of(EndKind end) {
  if (end == EndKind::periodic) return FluidEnd::Kind::periodic;
  return end == EndKind::no_slip ? FluidEnd::Kind::no_slip : FluidEnd::Kind::free_slip;
}

/// `size` numbers per atom that migrate with it and go into restart files.
LAMMPS_NS::FixPropertyAtom* add_vector_per_atom(LAMMPS_NS::Modify& modify, const char* name,
                                                std::size_t size, const char* caller) {
  std::vector<const char*> words{name, "all", "property/atom", name, "vector", "yes", "no", "no"};
  words.resize(words.size() + size, "0.");
  return modify.add_fix_property_atom(static_cast<int>(words.size()),
                                      const_cast<char**>(words.data()), caller);
}

/// Bit of the group behind `fixed`; 0: the line names none.
int fixed_bit_of(LAMMPS_NS::LAMMPS* lmp, int narg, char** arg) {
  const Arguments given(lmp, FixCoupleFluid::help,
                        std::span(arg, static_cast<std::size_t>(narg)).subspan(3));
  if (!given.has("fixed")) return 0;
  const int found = lmp->group->find(given.word("fixed").c_str());
  if (found < 0)
    stop_run(lmp, fmt::format("fix couple/fluid: the group '{}' behind 'fixed' does not exist",
                              given.word("fixed")));
  return lmp->group->bitmask[found];
}

}  // namespace

FixCoupleFluid::FixCoupleFluid(LAMMPS_NS::LAMMPS* lmp_, int narg, char** arg)
    : Fix(lmp_, narg, arg),
      side_(attached(world)),
      spheres_(lmp, groupbit, fixed_bit_of(lmp, narg, arg)),
      checks_(lmp, spheres_, side_) {
  if (side_ == nullptr)
    stop_run(lmp,
             "fix couple/fluid: this job has no fluid; start both programs, mpirun -np N "
             "bedload-fluid fluid.toml : -np M bedload-dem -in in.liggghts");
  if (find_fix(*modify, "couple/fluid") != nullptr)
    stop_run(lmp, "fix couple/fluid: the script has another one already; one is enough");
  if (side_->introduced() && !side_->stopped())
    stop_run(lmp,
             "fix couple/fluid: the fluid has begun with another one; let that stand until the "
             "last coupled_run is over");
  if (atom->map_style == 0)
    stop_run(lmp, "fix couple/fluid needs the line 'atom_modify map array' before the box is made");

  Fix* const table = find_fix(*modify, "collision/table");
  int dimension = 0;
  if (table != nullptr && table->extract("started", dimension) != nullptr)
    stop_run(
        lmp,
        "fix couple/fluid: the fix collision/table stands before a dry run, and --restart would "
        "begin its table anew; put it behind the dry run");

  vector_flag = 1;
  size_vector = 12;
  global_freq = 1;
  extvector = 1;
  restart_global = 1;

  const FluidSceneInfo& fluid = side_->scene_info();
  dt_fluid_ = fluid.time_step;
  viscosity_ = fluid.density * fluid.kinematic_viscosity;
  fluid_density_ = fluid.density;
  cell_size_ = fluid.cell_size;
  forcing_loops_ = static_cast<double>(fluid.forcing_loops);
  for (std::size_t end = 0; end < ends_.size(); ++end)
    ends_[end] = {kind_of(fluid.ends[end]), fluid.end_velocities[end]};
}

void FixCoupleFluid::post_create() {
  force_ = add_vector_per_atom(*modify, force_name, 3, style);
  torque_ = add_vector_per_atom(*modify, torque_name, 3, style);
  kept_ = add_vector_per_atom(*modify, kept_name, 7, style);
  overlap_ = add_vector_per_atom(*modify, overlap_name, 3, style);
  film_ = add_vector_per_atom(*modify, film_name, 6, style);
  std::array line{marker_film_name, static_cast<const char*>(group->names[igroup]),
                  FixMarkerFilm::style_name};
  modify->add_fix(static_cast<int>(line.size()), const_cast<char**>(line.data()));
}

void FixCoupleFluid::pre_delete(bool unfixflag) {
  if (!unfixflag) return;
  modify->delete_fix(force_name);
  modify->delete_fix(torque_name);
  modify->delete_fix(kept_name);
  modify->delete_fix(overlap_name);
  modify->delete_fix(film_name);
  if (find_marker_film(lmp) != nullptr) modify->delete_fix(marker_film_name);
}

int FixCoupleFluid::setmask() {
  using namespace LAMMPS_NS::FixConst;
  return POST_INTEGRATE | PRE_NEIGHBOR | POST_FORCE;
}

// Before LIGGGHTS initialises its dumps, which then open their files.
void FixCoupleFluid::init() {
  if (side_->restart_step() >= 0) append_to_dumps(*output);
  // Other commands (write_restart, delete_atoms overlap, ...) initialise LIGGGHTS and make no step.
  if (update->whichflag != 0 && !run_allowed_)
    stop_run(
        lmp,
        "fix couple/fluid: 'run' moves the grains without the fluid; use coupled_run, and put a "
        "dry run before this fix or behind 'unfix'");
  // LIGGGHTS makes these anew when it reads a restart.
  const auto find = [&](const char* name, int size) {
    return static_cast<LAMMPS_NS::FixPropertyAtom*>(
        modify->find_fix_property(name, "property/atom", "vector", size, 0, style));
  };
  force_ = find(force_name, 3);
  torque_ = find(torque_name, 3);
  kept_ = find(kept_name, 7);
  overlap_ = find(overlap_name, 3);
  film_ = find(film_name, 6);
  marker_film_ = find_marker_film(lmp);
  if (marker_film_ == nullptr)
    stop_run(lmp, fmt::format("fix couple/fluid: the fix '{}' is its own and was taken away; leave "
                              "its unfix out",
                              marker_film_name));
}

// At the start of a run the forces of the last step are wanted again: films made anew would know
// the velocities of its end.
void FixCoupleFluid::setup(int) {
  add_loads();
  if (ended_at_ == update->ntimestep)
    add_films_again();
  else
    marker_film_->act(film_->array_atom);
  done_ = {};
  checks_.note_gravity();
  if (!tags_noted_) note_tags();  // not before: Modify::setup gives new properties their defaults
}

void* FixCoupleFluid::extract(const char* name, int& dim) {
  dim = 0;
  const std::string_view wanted(name);
  if (wanted == "dt_fluid") return &dt_fluid_;
  if (wanted == "viscosity") return &viscosity_;
  if (wanted == "fluid_density") return &fluid_density_;
  if (wanted == "cell_size") return &cell_size_;
  if (wanted == "forcing_loops") return &forcing_loops_;
  if (wanted == "loads_received") return &loads_received_;
  if (wanted == "ends") return ends_.data();
  if (wanted == "impulse_on_walls") return &on_walls_;
  if (wanted == "goes_on" && side_->restart_step() >= 0) return &dt_fluid_;
  return nullptr;
}

// Before LIGGGHTS looks for the rank that a sphere belongs to now, and drops it without a word
// where there is none.
void FixCoupleFluid::post_integrate() { checks_.check_motion(dt_fluid_, deepest_in_walls); }

void FixCoupleFluid::allow_run(bool allowed) {
  run_allowed_ = allowed;
  if (!allowed) ended_at_ = update->ntimestep;
}

void FixCoupleFluid::check_before_run() {
  constexpr double deepest = 1.0;  // in radii; from deepest_in_walls on the fluid refuses it
  if (ended_at_ && *ended_at_ != update->ntimestep)
    stop_run(lmp,
             fmt::format("fix couple/fluid: LIGGGHTS is at step {}, but the coupled_run before "
                         "ended with step {}, and contacts under way count their steps; leave "
                         "out the reset_timestep between them",
                         update->ntimestep, *ended_at_));
  if (side_->scene_info().end_step < 0) refuse_moves_of_varying_steps();
  checks_.check_finite();
  check_spheres("since the coupled_run before", Moment::before_run);
  checks_.check_motion(dt_fluid_, deepest);  // the script may have moved them
  checks_.check_tags([this](int i) { return told_tag(i); });
  checks_.check_fixed();
}

void FixCoupleFluid::check_spheres(std::string_view since, Moment moment) {
  checks_.check_scene(since, moment);
  checks_.check_integrated();
  checks_.check_moved_once();
  checks_.warn_of_group();
  checks_.check_order(modify->find_fix(id));
  checked_inserted_ = inserted_spheres(lmp);
}

void FixCoupleFluid::check_inserted() {
  if (inserted_spheres(lmp) == checked_inserted_) return;
  check_spheres(fmt::format("after an insertion in step {}", side_->steps_made() + 1),
                Moment::during_run);
  if (const FixLubrication* const films = find_lubrication(lmp)) films->refuse_projected_spheres();
}

// f_i += F_i, torque_i += T_i, and the impulse that this gives to the spheres of this rank:
//   J += sum_i F_i dt
// What markers leave comes with it; of two that can move it has no impulse.
void FixCoupleFluid::add_loads() {
  double** const held_force = force_->array_atom;
  double** const held_torque = torque_->array_atom;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!spheres_.is_mobile(atom->mask[i])) continue;
    for (std::size_t d = 0; d < 3; ++d) {
      atom->f[i][d] += held_force[i][d];
      atom->torque[i][d] += held_torque[i][d];
      done_.impulse[d] += held_force[i][d] * update->dt;
      done_.angular_impulse[d] += held_torque[i][d] * update->dt;
    }
  }
}

void FixCoupleFluid::add_films_again() {
  for (int i = 0; i < atom->nlocal; ++i)
    for (std::size_t d = 0; d < 3; ++d) {
      atom->f[i][d] += film_->array_atom[i][d];
      atom->torque[i][d] += film_->array_atom[i][3 + d];
    }
}

void FixCoupleFluid::post_force(int) {
  add_loads();
  marker_film_->act(film_->array_atom);
  ++substeps_;
  take_mean();
}

// With the last sub-step of a fluid step:  mean = sum over its stages of J / (dt of the fluid)
void FixCoupleFluid::take_mean() {
  const DemSteps steps{side_->scene_info().dem_steps};
  const auto stage = static_cast<std::size_t>(stage_.header.stage);
  if (substeps_ != steps.in_stage[stage]) return;
  if (stage == 0 || !steps.exchange_in(0)) step_impulse_ = {};
  for (std::size_t d = 0; d < 3; ++d) {
    step_impulse_[d] += done_.impulse[d];
    step_impulse_[d + 3] += done_.angular_impulse[d];
  }
  if (stage + 1 != steps.in_stage.size()) return;
  for (std::size_t n = 0; n < step_mean_.size(); ++n) step_mean_[n] = step_impulse_[n] / dt_fluid_;
}

double FixCoupleFluid::compute_vector(int n) {
  constexpr int components = 6;
  if (n < components)
    return reduced(step_mean_[static_cast<std::size_t>(n)], MPI_DOUBLE, MPI_SUM, world);
  n -= components;
  double** const held = n < 3 ? force_->array_atom : torque_->array_atom;
  double sum = 0.0;
  for (int i = 0; i < atom->nlocal; ++i)
    if (spheres_.is_mobile(atom->mask[i])) sum += held[i][n % 3];
  return reduced(sum, MPI_DOUBLE, MPI_SUM, world);
}

// What f_ID[1..6] says until the next whole fluid step is over.
void FixCoupleFluid::write_restart(std::FILE* file) {
  std::array<double, 6> all{};
  MPI_Reduce(step_mean_.data(), all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, 0,
             world);
  if (comm->me != 0) return;
  const int bytes = sizeof(all);
  std::fwrite(&bytes, sizeof(bytes), 1, file);
  std::fwrite(all.data(), sizeof(all), 1, file);
}

void FixCoupleFluid::restart(char* buffer) {
  step_mean_ = {};
  if (comm->me == 0) std::memcpy(step_mean_.data(), buffer, sizeof(step_mean_));
}

void FixCoupleFluid::set_time_step(double fluid_time_step) {
  const double dt = DemSteps{side_->scene_info().dem_steps}.time_step(fluid_time_step);
  update->timestep_set = true;
  dt_fluid_ = fluid_time_step;
  if (dt == update->dt) return;
  update->update_time();  // the time so far was made of steps of the old length
  update->dt = dt;
  if (update->integrate) update->integrate->reset_dt();
  if (force->pair) force->pair->reset_dt();
  for (int i = 0; i < modify->nfix; ++i) {
    if (std::string_view(modify->fix[i]->style) != "move") modify->fix[i]->reset_dt();
    // Before the run begins it takes the step that is in force then (FixMove::init).
  }
}

// The length of the step varies where its number at the end is not known.
void FixCoupleFluid::refuse_moves_of_varying_steps() const {
  for (int i = 0; i < modify->nfix; ++i)
    if (std::string_view(modify->fix[i]->style) == "move")
      stop_run(lmp, fmt::format("fix couple/fluid: fix move ({}) knows one time step only, but "
                                "'time.cfl' of fluid.toml changes it; set time.cfl = 0",
                                modify->fix[i]->id));
}

Order FixCoupleFluid::receive_loads(bool first) {
  stage_ = side_->receive_loads();
  if (stage_.header.order != Order::advance) return stage_.header.order;
  done_ = {};
  on_walls_ = {};
  substeps_ = 0;
  done_.began = clock_seconds();
  done_.step = stage_.header.step;
  done_.stage = stage_.header.stage;
  if (first) hand_on_loads();
  hold_loads();
  return Order::advance;
}

void FixCoupleFluid::keep_forces() {
  for (int i = 0; i < atom->nlocal; ++i) {
    std::copy_n(atom->f[i], 3, kept_->array_atom[i]);
    std::copy_n(atom->torque[i], 3, kept_->array_atom[i] + 3);
  }
}

void FixCoupleFluid::put_back_forces() {
  for (int i = 0; i < atom->nlocal; ++i) {
    std::copy_n(kept_->array_atom[i], 3, atom->f[i]);
    std::copy_n(kept_->array_atom[i] + 3, 3, atom->torque[i]);
  }
}

// Place among this rank's atoms of the one that the fluid knows by `tag`, or -1: a new atom may
// have the tag of one that is gone.
int FixCoupleFluid::place_of(std::int64_t tag) const {
  const int i = owned_atom(*atom, static_cast<int>(tag));
  return i >= 0 && told_tag(i) == static_cast<double>(tag) ? i : -1;
}

double& FixCoupleFluid::told_tag(int i) const { return kept_->array_atom[i][6]; }

void FixCoupleFluid::note_tags() {
  for (int i = 0; i < atom->nlocal; ++i)
    if (spheres_.is_mobile(atom->mask[i])) told_tag(i) = atom->tag[i];
  tags_noted_ = true;
}

void FixCoupleFluid::note_overlaps() {
  const FluidSceneInfo& fluid = side_->scene_info();
  std::array<bool, 3> walls{};
  for (std::size_t d = 0; d < 3; ++d) walls[d] = fluid.periodic[d] == 0;
  const std::vector<Triple> overlaps = overlaps_of(lmp, spheres_, fluid.length, walls);
  for (std::size_t i = 0; i < overlaps.size(); ++i)
    std::copy(overlaps[i].begin(), overlaps[i].end(), overlap_->array_atom[i]);
}

// Atoms have changed rank, and fixes have deleted theirs.
void FixCoupleFluid::pre_neighbor() { hand_on_loads(); }

// The fluid answers to the rank that sent a sphere's motion. LIGGGHTS may have handed atoms to
// other ranks since, or deleted them.
void FixCoupleFluid::hand_on_loads() {
  std::vector<LoadRecord>& loads = stage_.loads;
  const auto stray = std::partition(loads.begin(), loads.end(), [this](const LoadRecord& load) {
    return place_of(load.tag) >= 0;
  });
  const std::vector<LoadRecord> strays(stray, loads.end());
  loads.erase(stray, loads.end());
  const auto take = [&](const LoadRecord& load) {
    if (place_of(load.tag) < 0) return false;
    loads.push_back(load);
    return true;
  };
  for (const LoadRecord& load : hand_on(world, neighbour_ranks(*comm), strays, take))
    book_lost(load);
}

// A sphere that is gone does not get the rest of its load: sum_i F_i (steps left) dt
void FixCoupleFluid::book_lost(const LoadRecord& load) {
  const DemSteps steps{side_->scene_info().dem_steps};
  const int left = steps.in_stage[static_cast<std::size_t>(stage_.header.stage)] - substeps_;
  const double time = left * steps.time_step(stage_.header.fluid_time_step);
  for (std::size_t d = 0; d < 3; ++d) {
    done_.lost[d] += load.force[d] * time;
    done_.angular_lost[d] += load.torque[d] * time;
  }
}

// Velocity Verlet's first half kick of the stage still uses the forces of the previous step's end.
// The new stage's load replaces the old one's there, so that a load acts for exactly its own stage:
//   f_i += P(F_i(new)) - P(F_i(old)),
// P what the fixes behind this one leave of a load that take components out of forces.
void FixCoupleFluid::hold_loads() {
  ++loads_received_;
  double** const held_force = force_->array_atom;
  double** const held_torque = torque_->array_atom;
  const std::vector<LAMMPS_NS::Fix*> projecting = projecting_fixes(*modify, modify->my_index(this));
  const auto projected = [&] {
    return projected_loads(*atom, held_force, held_torque, projecting);
  };
  const ForcesOnAtoms before = projecting.empty() ? ForcesOnAtoms{} : projected();
  for (const LoadRecord& load : stage_.loads) {
    const int i = place_of(load.tag);
    if (i < 0) continue;
    for (std::size_t d = 0; d < 3; ++d) {
      if (projecting.empty()) {
        atom->f[i][d] += load.force[d] - held_force[i][d];
        atom->torque[i][d] += load.torque[d] - held_torque[i][d];
      }
      held_force[i][d] = load.force[d];
      held_torque[i][d] = load.torque[d];
    }
  }
  if (projecting.empty()) return;
  const ForcesOnAtoms now = projected();
  for (int i = 0; i < atom->nlocal; ++i)
    for (std::size_t d = 0; d < 3; ++d) {
      const auto n = static_cast<std::size_t>(i);
      atom->f[i][d] += now.force[n][d] - before.force[n][d];
      atom->torque[i][d] += now.torque[n][d] - before.torque[n][d];
    }
}

void FixCoupleFluid::renew_motion() {
  if (!must_send_motion_) return;
  done_ = {};
  send_motion();
}

void FixCoupleFluid::send_motion(bool changes_follow) {
  must_send_motion_ = changes_follow;
  done_.renewed = changes_follow ? 1 : 0;
  checks_.check_motion(dt_fluid_, deepest_in_walls);
  checks_.check_gravity_during_run();
  // Once per step: behind the first sub-steps.
  if (done_.stage == 0 || !DemSteps{side_->scene_info().dem_steps}.exchange_in(0))
    collisions_ = finished_collisions();
  done_.collisions = collisions_;
  done_.on_lower_walls = on_walls_.below;
  done_.on_upper_walls = on_walls_.above;
  done_.ended = clock_seconds();
  try {
    note_overlaps();
    // A script may have deleted a sphere and made another one, which has the free number.
    const auto is_new = [this](int i) { return told_tag(i) != atom->tag[i]; };
    const std::vector<StateRecord> states = spheres_.states(false, overlap_->array_atom, is_new);
    note_tags();
    side_->send_motion(done_, states);
  } catch (const UserError& error) {
    end_job(Program::dem, comm->me, fmt::format("fix couple/fluid: {}", error.what()));
  }
}

// The count over all ranks travels with rank 0's states.
std::int64_t FixCoupleFluid::finished_collisions() const {
  LAMMPS_NS::Fix* const table = modify->find_fix_style_strict("collision/table", 0);
  const auto count = table == nullptr ? -1 : static_cast<std::int64_t>(table->compute_scalar());
  return comm->me == 0 ? count : 0;
}

void FixCoupleFluid::shake_hands() {
  if (side_->introduced()) return;
  checks_.check_fixed();
  checks_.note_fixed();
  const DemSceneInfo scene_info = describe_scene(lmp, spheres_);
  // A new run has noted none yet; one that starts from a checkpoint has read them.
  const bool noted = side_->restart_step() >= 0;
  side_->introduce(scene_info, describe_effects(lmp),
                   spheres_.states(true, noted ? overlap_->array_atom : nullptr));
  // Atoms change rank when neighbour lists are built, by then at most a skin out of the region;
  // what comes later may be twice as large.
  side_->find_partners({.low = triple(domain->sublo),
                        .high = triple(domain->subhi),
                        .margin = neighbor->skin,
                        .largest_radius = 2.0 * spheres_.largest_radius()});
}

}  // namespace bedload
