#include "coupling/bedload_dem/fix_couple_fluid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "atom.h"
#include "comm.h"
#include "coupling/bedload_dem/attach.hpp"
#include "coupling/bedload_dem/restarted_dumps.hpp"
#include "coupling/bedload_dem/script_gravity.hpp"
#include "coupling/bedload_dem/script_rules.hpp"
#include "coupling/exchange/clock.hpp"
#include "coupling/exchange/handshake.hpp"
#include "coupling/exchange/stages.hpp"
#include "coupling/job/roles.hpp"
#include "domain.h"
#include "error.h"
#include "fix_property_atom.h"
#include "fluid/kernels/fnv.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/validation/validate.hpp"
#include "force.h"
#include "group.h"
#include "integrate.h"
#include "lammps.h"
#include "liggghts_styles/fix_lubrication.hpp"
#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/hand_on.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/mobility.hpp"
#include "liggghts_styles/owned_atom.hpp"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "pair.h"
#include "pair_gran.h"
#include "update.h"

namespace bedload {
namespace {

constexpr const char* force_name = "couple_force";
constexpr const char* torque_name = "couple_torque";
constexpr const char* kept_name = "couple_kept";

/// `size` numbers per atom that migrate with it and go into restart files.
LAMMPS_NS::FixPropertyAtom* add_vector_per_atom(LAMMPS_NS::Modify& modify, const char* name,
                                                std::size_t size, const char* caller) {
  std::vector<const char*> words{name, "all", "property/atom", name, "vector", "yes", "no", "no"};
  words.resize(words.size() + size, "0.");
  return modify.add_fix_property_atom(static_cast<int>(words.size()),
                                      const_cast<char**>(words.data()), caller);
}

/// pair_style and, for granular contacts, the models in it that have a name here.
std::string describe_contacts(LAMMPS_NS::Force& force) {
  std::string text = fmt::format("pair_style {}", force.pair_style);
  if (std::string_view(force.pair_style) != "gran") return text;
  auto& pair = static_cast<LAMMPS_NS::PairGran&>(*force.pair);
  constexpr std::array<std::array<const char*, 3>, 8> models{
      {{"normal", "model", "actm"},
       {"normal", "model", "rpm"},
       {"normal", "model", "hertz"},
       {"normal", "model", "hooke"},
       {"tangential", "tangential", "haff_werner"},
       {"tangential", "tangential", "history"},
       {"tangential", "tangential", "no_history"},
       {"cohesion", "cohesion", "sjkr"}}};
  for (const auto& [kind, keyword, name] : models)
    if (pair.contact_match(kind, name)) text += fmt::format(" {} {}", keyword, name);
  return text;
}

Triple triple(const double* v) { return {v[0], v[1], v[2]}; }

template <class T>
T reduced(T value, MPI_Datatype type, MPI_Op operation, MPI_Comm world) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, type, operation, world);
  return value;
}

}  // namespace

FixCoupleFluid::FixCoupleFluid(LAMMPS_NS::LAMMPS* lmp_, int narg, char** arg)
    : Fix(lmp_, narg, arg), side_(attached(world)) {
  const Arguments given(lmp, help, std::span(arg, static_cast<std::size_t>(narg)).subspan(3));
  if (given.has("fixed")) {
    const int found = group->find(given.word("fixed").c_str());
    if (found < 0)
      stop_run(lmp, fmt::format("fix couple/fluid: the group '{}' behind 'fixed' does not exist",
                                given.word("fixed")));
    fixed_bit_ = group->bitmask[found];
  }
  if (side_ == nullptr)
    stop_run(lmp,
             "fix couple/fluid: this job has no fluid; start both programs, mpirun -np N "
             "bedload-fluid fluid.toml : -np M bedload-dem -in in.liggghts");
  if (modify->n_fixes_style_strict("couple/fluid") > 0)
    stop_run(lmp, "fix couple/fluid: the script has another one already; one is enough");
  if (atom->map_style == 0)
    stop_run(lmp, "fix couple/fluid needs the line 'atom_modify map array' before the box is made");

  Fix* const table = modify->find_fix_style_strict("collision/table", 0);
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

  const FluidSceneInfo& fluid = side_->scene_info();
  dt_fluid_ = fluid.time_step;
  viscosity_ = fluid.density * fluid.kinematic_viscosity;
  fluid_density_ = fluid.density;
  cell_size_ = fluid.cell_size;
}

void FixCoupleFluid::post_create() {
  force_ = add_vector_per_atom(*modify, force_name, 3, style);
  torque_ = add_vector_per_atom(*modify, torque_name, 3, style);
  kept_ = add_vector_per_atom(*modify, kept_name, 7, style);
}

void FixCoupleFluid::pre_delete(bool unfixflag) {
  if (!unfixflag) return;
  modify->delete_fix(force_name);
  modify->delete_fix(torque_name);
  modify->delete_fix(kept_name);
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
}

void FixCoupleFluid::setup(int vflag) {
  post_force(vflag);
  done_ = {};
  if (!tags_noted_) note_tags();  // not before: Modify::setup gives new properties their defaults
}

void* FixCoupleFluid::extract(const char* name, int& dim) {
  dim = 0;
  const std::string_view wanted(name);
  if (wanted == "dt_fluid") return &dt_fluid_;
  if (wanted == "viscosity") return &viscosity_;
  if (wanted == "fluid_density") return &fluid_density_;
  if (wanted == "cell_size") return &cell_size_;
  if (wanted == "loads_received") return &loads_received_;
  return nullptr;
}

// Before LIGGGHTS looks for the rank that a sphere belongs to now, and drops it without a word
// where there is none.
void FixCoupleFluid::post_integrate() { check_motion(deepest_in_walls); }

// What the script has placed deeper in a wall than this the fluid refuses.
void FixCoupleFluid::check_motion() const { check_motion(1.0); }

// (|v| + |omega| R) dt <= R: beyond that contacts are missed. The rule for walls is that of
// fluid/validation, which looks at spheres when they come or change.
void FixCoupleFluid::check_motion(double deepest) const {
  check_box_and_step();
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!is_mobile(atom->mask[i])) continue;
    const Vec3 x = vec3(triple(atom->x[i])), v = vec3(triple(atom->v[i]));
    const double speed = v.norm() + vec3(triple(atom->omega[i])).norm() * atom->radius[i];
    std::string what;
    if (!(speed * update->dt <= atom->radius[i]))
      what =
          "moves by more than its radius in one step of LIGGGHTS; reduce 'time.step' of fluid.toml";
    else if (!is_inside(x))
      what =
          "has left the box; put a 'fix wall/gran' where the box ends, or reduce 'time.step' of "
          "fluid.toml";
    else if (const auto depth = depth_in_walls(x, atom->radius[i]);
             depth > deepest * atom->radius[i])
      what = fmt::format(
          "reaches {:.3g} out of the box, and at most {} of its radius is allowed; put a 'fix "
          "wall/gran' where the box ends, or reduce 'time.step' of fluid.toml",
          depth, deepest);
    if (what.empty()) continue;
    end_job(Program::dem, comm->me,
            fmt::format(
                "fix couple/fluid: step {}: atom {} at ({:.6g}, {:.6g}, {:.6g}) with velocity "
                "({:.3g}, {:.3g}, {:.3g}) {}.",
                side_->steps_made() + 1, atom->tag[i], x[0], x[1], x[2], v[0], v[1], v[2], what));
  }
}

// The fluid's grid stands still, and its loads are impulses of its own time step.
void FixCoupleFluid::check_box_and_step() const {
  if (!side_->introduced()) return;  // the hand-shake will compare them
  DemSceneInfo now{};
  describe_box(now);
  const double dt = DemSteps{side_->scene_info().dem_steps}.time_step(dt_fluid_);
  std::string sentence;
  if (const auto other = box_disagreement(side_->scene_info(), now))
    sentence = fmt::format("{} No fix may change it during a coupled_run.", *other);
  else if (!(std::abs(update->dt - dt) <= 1e-12 * dt))
    sentence = fmt::format(
        "the time step of LIGGGHTS is {:.6g}, but fluid.toml (time.step, coupling.dem_steps) makes "
        "it {:.6g}; no fix (dt/reset, say) may change it during a coupled_run.",
        update->dt, dt);
  if (!sentence.empty())
    end_job(Program::dem, comm->me,
            fmt::format("fix couple/fluid: step {}: {}", side_->steps_made() + 1, sentence));
}

bool FixCoupleFluid::is_inside(const Vec3& position) const {
  for (int d = 0; d < 3; ++d)
    if (domain->periodicity[d] == 0 &&
        !(position[d] >= domain->boxlo[d] && position[d] <= domain->boxhi[d]))
      return false;
  return true;
}

double FixCoupleFluid::depth_in_walls(const Vec3& position, double radius) const {
  double depth = -std::numeric_limits<double>::infinity();
  for (int d = 0; d < 3; ++d) {
    if (domain->periodicity[d] != 0) continue;
    const double way = std::min(position[d] - domain->boxlo[d], domain->boxhi[d] - position[d]);
    depth = std::max(depth, radius - way);
  }
  return depth;
}

// f_i += F_i, torque_i += T_i, and the impulse that this gives to the spheres of this rank:
//   J += sum_i F_i dt
void FixCoupleFluid::post_force(int) {
  double** const held_force = force_->array_atom;
  double** const held_torque = torque_->array_atom;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!is_mobile(atom->mask[i])) continue;
    for (std::size_t d = 0; d < 3; ++d) {
      atom->f[i][d] += held_force[i][d];
      atom->torque[i][d] += held_torque[i][d];
      done_.impulse[d] += held_force[i][d] * update->dt;
      done_.angular_impulse[d] += held_torque[i][d] * update->dt;
    }
  }
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
    if (is_mobile(atom->mask[i])) sum += held[i][n % 3];
  return reduced(sum, MPI_DOUBLE, MPI_SUM, world);
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
    if (std::string_view(modify->fix[i]->style) != "move")
      modify->fix[i]->reset_dt();
    else if (update->whichflag != 0)
      stop_run(lmp, fmt::format("fix couple/fluid: fix move ({}) knows one time step only, but "
                                "'time.cfl' of fluid.toml changes it; set time.cfl = 0",
                                modify->fix[i]->id));
    // Before the run begins it takes the step that is in force then (FixMove::init).
  }
}

Order FixCoupleFluid::receive_loads(bool first) {
  stage_ = side_->receive_loads();
  if (stage_.header.order != Order::advance) return stage_.header.order;
  done_ = {};
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
    if (is_mobile(atom->mask[i])) told_tag(i) = atom->tag[i];
  tags_noted_ = true;
}

void FixCoupleFluid::check_tags() const {
  const auto renumbered = lowest_tag([this](int i) {
    return is_mobile(atom->mask[i]) && told_tag(i) != 0.0 && told_tag(i) != atom->tag[i];
  });
  if (renumbered)
    stop_run(lmp,
             fmt::format("fix couple/fluid: atom {} had another number in the coupled_run before, "
                         "and the fluid knows the spheres by their numbers; delete atoms with "
                         "'delete_atoms ... compress no'",
                         *renumbered));
}

template <class Condition>
std::optional<int> FixCoupleFluid::lowest_tag(Condition holds) const {
  constexpr int none = std::numeric_limits<int>::max();
  int lowest = none;
  for (int i = 0; i < atom->nlocal; ++i)
    if (holds(i)) lowest = std::min(lowest, atom->tag[i]);
  lowest = reduced(lowest, MPI_INT, MPI_MIN, world);
  return lowest == none ? std::nullopt : std::optional(lowest);
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
//   f_i += F_i(new) - F_i(old)
void FixCoupleFluid::hold_loads() {
  double** const held_force = force_->array_atom;
  double** const held_torque = torque_->array_atom;
  ++loads_received_;
  for (const LoadRecord& load : stage_.loads) {
    const int i = place_of(load.tag);
    if (i < 0) continue;
    for (std::size_t d = 0; d < 3; ++d) {
      atom->f[i][d] += load.force[d] - held_force[i][d];
      atom->torque[i][d] += load.torque[d] - held_torque[i][d];
      held_force[i][d] = load.force[d];
      held_torque[i][d] = load.torque[d];
    }
  }
  project_forces();
}

// Fixes that project forces (a sphere held in its plane, say) and stand behind this one have seen
// the old load; they see the new one now. Projecting twice changes nothing.
void FixCoupleFluid::project_forces() {
  for (int n = modify->my_index(this) + 1; n < modify->nfix; ++n) {
    const std::string_view their_style(modify->fix[n]->style);
    if (their_style == "freeze" || projects_forces(their_style)) modify->fix[n]->post_force(0);
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
  check_motion(deepest_in_walls);
  // Once per step: behind the first sub-steps.
  if (done_.stage == 0 || !DemSteps{side_->scene_info().dem_steps}.exchange_in(0))
    collisions_ = finished_collisions();
  done_.collisions = collisions_;
  done_.ended = clock_seconds();
  try {
    note_tags();
    side_->send_motion(done_, states(false));
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

std::vector<StateRecord> FixCoupleFluid::states(bool with_fixed) const {
  std::vector<StateRecord> records;
  for (int i = 0; i < atom->nlocal; ++i) {
    const bool mobile = is_mobile(atom->mask[i]);
    if (!mobile && !(with_fixed && is_fixed(atom->mask[i]))) continue;
    Triple position = triple(atom->x[i]);
    domain->remap(position.data());
    records.push_back({atom->tag[i], position, triple(atom->v[i]), triple(atom->omega[i]),
                       atom->radius[i], mobile ? atom->density[i] : 0.0, mobile ? 1 : 0});
  }
  return records;
}

void FixCoupleFluid::shake_hands() {
  if (side_->introduced()) return;
  check_fixed();
  told_fixed_ = fingerprint_of_fixed();
  const DemSceneInfo scene_info = collect_scene_info();
  side_->introduce(scene_info, describe_effects(), states(true));
  // Atoms change rank when neighbour lists are built, by then at most a skin out of the region;
  // what comes later may be twice as large.
  side_->find_partners({.low = triple(domain->sublo),
                        .high = triple(domain->subhi),
                        .margin = neighbor->skin,
                        .largest_radius = 2.0 * largest_radius()});
}

/// Of all spheres in the fluid [L]. Collective.
double FixCoupleFluid::largest_radius() const {
  double largest = 0.0;
  for (int i = 0; i < atom->nlocal; ++i)
    if ((atom->mask[i] & groupbit) != 0) largest = std::max(largest, atom->radius[i]);
  return reduced(largest, MPI_DOUBLE, MPI_MAX, world);
}

// A fix move, or nve/noforce with a speed, moves spheres that a fix freeze has as well.
void FixCoupleFluid::check_prescribed() const {
  for (int n = 0; n < modify->nfix; ++n) {
    const Fix& fix = *modify->fix[n];
    const std::string_view their_style(fix.style);
    const bool moves = their_style == "move", goes_on = their_style == "nve/noforce";
    if (!moves && !goes_on) continue;
    const auto moving = lowest_tag([&](int i) {
      return is_fixed(atom->mask[i]) && (atom->mask[i] & fix.groupbit) != 0 &&
             (moves || vec3(triple(atom->v[i])).norm() > 0.0);
    });
    if (moving)
      stop_run(lmp, fmt::format("fix couple/fluid: fix {} (id {}) moves atom {}, which is in the "
                                "group behind 'fixed', and the fluid receives those once; take it "
                                "out of that group, so that it is mobile, or out of the fix's",
                                fix.style, fix.id, *moving));
  }
}

// A fixed sphere that something moves would leave its markers behind.
void FixCoupleFluid::check_fixed() const {
  check_prescribed();
  const Mobility mobility(lmp);
  const auto moving =
      lowest_tag([&](int i) { return is_fixed(atom->mask[i]) && !mobility.held(atom->mask[i]); });
  if (moving)
    stop_run(lmp,
             fmt::format("fix couple/fluid: atom {} is in the group behind 'fixed' but is moved "
                         "by an integrating fix; freeze it ('fix ID GROUP freeze') or keep the "
                         "integrating fix to the other atoms",
                         *moving));
  if (side_->introduced() && fingerprint_of_fixed() != told_fixed_)
    stop_run(lmp,
             "fix couple/fluid: the spheres of the group behind 'fixed' are no more those of the "
             "coupled_run before (number, place, speed, size), and the fluid receives them once; "
             "leave them as they are between two coupled_runs");
}

void FixCoupleFluid::check_fixed_during_run() const {
  if (fingerprint_of_fixed() != told_fixed_)
    stop_run(lmp, fmt::format("fix couple/fluid: step {}: the spheres of the group behind 'fixed' "
                              "have changed during this coupled_run (number, place, speed, size), "
                              "and the fluid receives them once; take the fix that changes them "
                              "(move, adapt, say) from the script or those spheres from its group",
                              side_->steps_made()));
}

// The same on any ranks and in any order: FNV-1a of each sphere, and their exclusive or.
std::uint64_t FixCoupleFluid::fingerprint_of_fixed() const {
  std::uint64_t all = 0;
  for (const StateRecord& sphere : states(true)) {
    if (sphere.mobile != 0) continue;
    std::uint64_t hash = fnv_start;
    for (const std::uint64_t word :
         std::bit_cast<std::array<std::uint64_t, sizeof(StateRecord) / 8>>(sphere))
      hash = fnv_mixed(hash, word);
    all ^= hash;
  }
  return reduced(all, MPI_UINT64_T, MPI_BXOR, world);
}

void FixCoupleFluid::check_scene() const {
  if (!side_->introduced()) return;
  if (const auto sentence = disagreement(side_->scene_info(), collect_scene_info()))
    stop_run(lmp, fmt::format("fix couple/fluid: since the coupled_run before, {}", *sentence));
}

void FixCoupleFluid::check_integrated() const {
  const Mobility mobility(lmp);
  const auto left_alone = [&](int i) {
    return is_mobile(atom->mask[i]) && mobility.left_alone(atom->mask[i]);
  };
  const auto moving = lowest_tag([&](int i) {
    return left_alone(i) &&
           (vec3(triple(atom->v[i])).norm() > 0.0 || vec3(triple(atom->omega[i])).norm() > 0.0);
  });
  if (moving)
    stop_run(lmp, fmt::format("fix couple/fluid: atom {} is mobile and has a speed, but no fix "
                              "moves it; put it in the group of a 'fix nve/sphere', set its "
                              "velocity to 0, or take it into the group behind 'fixed'",
                              *moving));
  if (const auto still = lowest_tag(left_alone); still && comm->me == 0)
    error->warning(FLERR, fmt::format("fix couple/fluid: atom {} (and others perhaps) is mobile, "
                                      "but no fix moves it, so that it stays where it is; put it "
                                      "in the group of a 'fix nve/sphere'",
                                      *still)
                              .c_str());
}

void FixCoupleFluid::describe_box(DemSceneInfo& scene_info) const {
  scene_info.box_low = triple(domain->boxlo);
  scene_info.box_high = triple(domain->boxhi);
  scene_info.periodic = {domain->periodicity[0], domain->periodicity[1], domain->periodicity[2]};
}

DemSceneInfo FixCoupleFluid::collect_scene_info() const {
  DemSceneInfo scene_info{};
  describe_box(scene_info);
  const Mobility mobility(lmp);
  const ScriptGravity gravity = script_gravity(
      lmp, [&](int i) { return is_mobile(atom->mask[i]) && !mobility.held(atom->mask[i]); });
  if (gravity.other)
    stop_run(lmp, fmt::format("fix couple/fluid: atom {} has another gravity than other mobile "
                              "spheres; put all of them in the group of 'fix gravity'",
                              *gravity.other));
  scene_info.has_gravity = gravity.stated ? 1 : 0;
  scene_info.gravity = gravity.value;
  scene_info.force_factor = force->ftm2v;
  for (int i = 0; i < atom->nlocal; ++i)
    if ((atom->mask[i] & groupbit) != 0)
      ++(is_mobile(atom->mask[i]) ? scene_info.mobile : scene_info.fixed);
  scene_info.mobile = reduced(scene_info.mobile, MPI_INT64_T, MPI_SUM, world);
  scene_info.fixed = reduced(scene_info.fixed, MPI_INT64_T, MPI_SUM, world);
  scene_info.inserts = inserting_fixes(lmp);
  // A script may state the fluid's values for use without a fluid; then they have to be the same.
  const FluidValue density = FluidValue::find(lmp, "", "fluidDensity");
  const FluidValue viscosity = FluidValue::find(lmp, "", "fluidViscosity");
  scene_info.density = density.known() ? density.get() : std::numeric_limits<double>::quiet_NaN();
  scene_info.viscosity =
      viscosity.known() ? viscosity.get() : std::numeric_limits<double>::quiet_NaN();
  return scene_info;
}

std::string FixCoupleFluid::describe_effects() const {
  const bool contacts = force->pair != nullptr;
  const auto* film =
      dynamic_cast<const FixLubrication*>(modify->find_fix_style_strict("lubrication", 0));
  const auto line = [](const char* effect, bool on, const std::string& why) {
    return fmt::format("{}\t{}\t{}\n", effect, on ? "on" : "off", why);
  };
  return line("collisions", contacts,
              contacts ? describe_contacts(*force) : "the LIGGGHTS script has no pair_style") +
         line("lubrication", film != nullptr,
              film != nullptr ? "fix lubrication" : "the LIGGGHTS script has no fix lubrication") +
         line("films against sliding and rolling", film != nullptr && film->tangential(),
              film == nullptr      ? "no fix lubrication"
              : film->tangential() ? "fix lubrication tangential on"
                                   : "fix lubrication tangential off, as the published models");
}

}  // namespace bedload
