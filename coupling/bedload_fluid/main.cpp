// bedload-fluid: the flow. Beside bedload-dem in one MPI job its spheres are LIGGGHTS' atoms and
// move; alone it computes a flow without spheres or around fixed ones. simulation.cpp has the time
// step.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "coupling/bedload_fluid/effects.hpp"
#include "coupling/bedload_fluid/options.hpp"
#include "coupling/bedload_fluid/run_output.hpp"
#include "coupling/bedload_fluid/simulation.hpp"
#include "coupling/checkpoint/checkpoints.hpp"
#include "coupling/exchange/clock.hpp"
#include "coupling/exchange/fluid_side.hpp"
#include "coupling/exchange/stages.hpp"
#include "coupling/job/peer_failure.hpp"
#include "coupling/job/roles.hpp"
#include "coupling/job/run_lock.hpp"
#include "coupling/job/signals.hpp"
#include "fluid/checkpoint/state_file.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/grid/block_map.hpp"
#include "fluid/grid/division.hpp"
#include "fluid/immersed_boundary/sphere_file.hpp"
#include "fluid/kernels/subnormals.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/settings/settings.hpp"
#include "fluid/validation/validate.hpp"

namespace bedload {
namespace {

/// Steps of the length `step` that a time takes. One that is over by round-off is none: a time that
/// is the sum of a million steps is off by 1e-5 of one.
std::int64_t steps_in(double time, double step) {
  constexpr double rounding = 1e-3;
  return std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(time / step - rounding)));
}

EndKind kind_of(Wall wall) {
  if (wall == Wall::periodic) return EndKind::periodic;
  return wall == Wall::no_slip ? EndKind::no_slip : EndKind::free_slip;
}

FluidSceneInfo scene_info_of(const Settings& s, const Resumption* from) {
  FluidSceneInfo scene_info{};
  scene_info.length = s.grid.length;
  const auto periodic = [](const auto& ends) { return ends[0] == Wall::periodic ? 1 : 0; };
  scene_info.periodic = {periodic(s.boundary.x), periodic(s.boundary.y), periodic(s.boundary.z)};
  const std::array ends{s.boundary.x, s.boundary.y, s.boundary.z};
  for (std::size_t end = 0; end < 6; ++end) scene_info.ends[end] = kind_of(ends[end / 2][end % 2]);
  scene_info.end_velocities = {s.boundary.x_lower_velocity, s.boundary.x_upper_velocity,
                               s.boundary.y_lower_velocity, s.boundary.y_upper_velocity,
                               s.boundary.z_lower_velocity, s.boundary.z_upper_velocity};
  scene_info.dem_steps =
      DemSteps::of(s.coupling.exchange == Exchange::stage, s.coupling.dem_steps).in_stage;
  scene_info.gravity = s.fluid.gravity;
  scene_info.density = s.fluid.density;
  scene_info.kinematic_viscosity = s.fluid.kinematic_viscosity;
  scene_info.time_step = from && s.time.cfl > 0.0 ? from->time_step() : s.time.step;
  scene_info.restart_step = from ? from->header.step : -1;
  const double time_left = s.time.end - (from ? from->header.time : 0.0);
  if (s.time.cfl == 0.0 && time_left / s.time.step <= most_steps)
    scene_info.end_step = (from ? from->header.step : 0) + steps_in(time_left, s.time.step);
  scene_info.cell_size = s.grid.length[0] / s.grid.cells[0];
  scene_info.forcing_loops = s.spheres.forcing_loops;
  return scene_info;
}

/// The spheres of a run without LIGGGHTS, which stay where they are.
std::vector<SphereState> spheres_of(const Settings& s) {
  if (s.spheres.file.empty()) return {};
  return read_spheres(s.beside(s.spheres.file), make_grid(s));
}

/// A scene that has a LIGGGHTS script is without its grains only for somebody who says so.
void check_partner(const Settings& s, const FluidOptions& options) {
  const std::string script = s.beside("in.liggghts");
  std::error_code error;
  if (options.without_grains || !s.spheres.file.empty() || !std::filesystem::exists(script, error))
    return;
  throw UserError(fmt::format(
      "{}: the scene has grains ({}), but bedload-dem is not in the job; start both, mpirun -np N "
      "bedload-fluid {} : -np M bedload-dem -in {}, or the flow alone with --without-grains.",
      s.file, "in.liggghts", s.file, script));
}

/// A grid that cannot fit is refused before the machine is brought to a halt.
void check_memory(const Settings& s, const Job& job) {
  const double needed = least_field_bytes(s) / job.size() * job.ranks_here();
  const double there =
      static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (needed > there)
    throw UserError(fmt::format(
        "{}: 'grid.cells' = [{}] takes at least {:.3g} GB on each machine of the job, but this one "
        "has {:.3g} GB.",
        s.file, fmt::join(s.grid.cells, ", "), 1e-9 * needed, 1e-9 * there));
}

/// A run begins in a folder without checkpoints, or goes on in its own.
void check_no_run_is_lost(const std::string& out, const Resumption* from) {
  const auto there = find_checkpoints(out);
  if (there.empty()) return;
  std::error_code error;
  if (from && std::filesystem::equivalent(
                  out, std::filesystem::path(from->place.folder).parent_path(), error))
    return;
  throw UserError(fmt::format(
      "{}: the folder holds the checkpoints of {}, the last one after step {}; go on from them "
      "with "
      "--restart {}, give this run another folder with --out, or have them removed with "
      "--overwrite.",
      out, from ? "another run" : "a run", there.back().step, out));
}

/// Start from the flow of another run (start.from = "state"); time and step begin anew.
template <class Real>
void start_from_state(Channel<Real>& channel) {
  const Settings& s = channel.settings();
  const StateRead state = read_state(s.beside(s.start.file), channel.grid(),
                                     channel.decomposition(), channel.fields_to_restore());
  channel.shift_to_bulk_velocity();
  channel.restored(0.0, 0, state.header.driving, state.interpolated);
}

/// Steps from now to time.end with the present time step, or as many as the command line allows.
template <class Real>
std::int64_t count_steps(const Channel<Real>& channel, std::int64_t most) {
  const double left = channel.settings().time.end - channel.time();
  if (left / channel.time_step() > most_steps)
    throw UserError(
        fmt::format("{}: after step {} (t = {:.6g}): the time step has shrunk to {:.3g}, with "
                    "which {:.3g} more "
                    "are left to 'time.end' = {}, and at most {:.0e} are allowed; the flow grows "
                    "without bound, "
                    "or 'time.cfl' = {} is too small.",
                    channel.settings().file, channel.step(), channel.time(), channel.time_step(),
                    left / channel.time_step(), channel.settings().time.end, most_steps,
                    channel.settings().time.cfl));
  const std::int64_t steps = steps_in(left, channel.time_step());
  return most < 0 ? steps : std::min(steps, most);
}

/// What both programs did in the last step: program,part,start,end in seconds since its begin.
template <class Real>
std::string time_line(Simulation<Real>& simulation, const std::vector<TimelineEntry>& fluid,
                      double began) {
  std::string text = "program,part,start,end\n";
  for (const TimelineEntry& e : fluid)
    text += fmt::format("bedload-fluid,{},{:.7f},{:.7f}\n", simulation.timing().name(e.phase),
                        e.start, e.end);
  for (const GrainInterval& g : simulation.grain_intervals())
    text +=
        fmt::format("bedload-dem,grain motion,{:.7f},{:.7f}\n", g.began - began, g.ended - began);
  return text;
}

/// Status of a run that was asked to end, and ended with a checkpoint.
constexpr int ended_early = 3;

/// The spheres near this rank's block of the box, which is divided by `cuts`, or where these are
/// empty as suits the spheres. Collective.
/// @param overlaps whether pairs may overlap as they do: those of a run that goes on came to it
std::vector<SphereState> share_out(FluidSide& partner, const PartnerScene& dem,
                                   const Settings& settings, const Job& job, Overlaps overlaps,
                                   Cuts& cuts) {
  collectively(job.own(), [&] { validate(settings, dem.told, overlaps); });
  const Grid grid = make_grid(settings);
  if (cuts.y.empty())
    cuts =
        choose_cuts_together(job.own(), grid, dem.told, settings.ranks.along_z, settings.spheres);
  std::vector<SphereState> near = partner.share_out(block_map(grid, cuts));
  // Pairs that two ranks knew of.
  collectively(job.own(), [&] { validate(settings, near, overlaps); });
  return near;
}

/// Where the box is divided, the spheres near this rank's part of it, and how many there are in
/// all.
struct NearSpheres {
  Cuts cuts;
  std::vector<SphereState> spheres;
  SphereNumbers numbers;
};

/// Those of the partner, or of the scene where there is none. Collective.
NearSpheres near_spheres(FluidSide* partner, const PartnerScene* dem, const Settings& settings,
                         const Job& job, const Resumption* from) {
  NearSpheres near;
  if (from) near.cuts = from->cuts(job.size(), settings);
  if (dem) {
    near.spheres = share_out(*partner, *dem, settings, job,
                             from ? Overlaps::as_they_are : Overlaps::slight, near.cuts);
    near.numbers = {.fixed = dem->scene_info.fixed, .mobile = dem->scene_info.mobile};
  } else {
    near.spheres = spheres_of(settings);
    near.numbers.fixed = static_cast<std::int64_t>(near.spheres.size());
    if (from) check_fixed_spheres(*from, near.spheres);
  }
  for (const SphereState& sphere : near.spheres)
    near.numbers.widest = std::max(near.numbers.widest, 2.0 * sphere.radius);
  MPI_Allreduce(MPI_IN_PLACE, &near.numbers.widest, 1, MPI_DOUBLE, MPI_MAX, job.own());
  return near;
}

/// What the time loop leaves.
struct Advanced {
  std::int64_t steps = 0;
  std::string time_line;                 ///< of the last step
  std::optional<std::string> cut_short;  ///< why it ended before its time
};

/// `left` steps, or as many as it takes to time.end where time.cfl makes them.
template <class Real>
Advanced advance(Simulation<Real>& simulation, RunOutput<Real>& output,
                 Checkpoints<Real>& checkpoints, const FluidOptions& options, std::int64_t left) {
  Advanced made;
  const std::int64_t most = options.steps;
  while (left > 0 && !made.cut_short) {
    const bool last = left == 1;
    const double began = clock_seconds();
    if (made.steps == options.warm_up) simulation.timing().restart();
    if (last) simulation.timing().record_step();
    simulation.make_step(last);
    if (last) made.time_line = time_line(simulation, simulation.timing().stop_recording(), began);
    output.after_step();
    ++made.steps;
    left = last ? 0 : count_steps(simulation.channel(), most < 0 ? most : most - made.steps);
    made.cut_short = checkpoints.after_step();
  }
  return made;
}

template <class Real>
int simulate(Job& job, const FluidOptions& options, const Settings& settings, FluidSide* partner,
             const PartnerScene* dem, Resumption* from) {
  if (from) learn_transforms(*from);
  NearSpheres near = near_spheres(partner, dem, settings, job, from);
  Simulation<Real> simulation(settings, job.own(), partner, near.spheres, near.cuts);
  near.spheres = {};
  if (from) {
    restore_flow(*from, simulation.channel());
  } else if (settings.start.from == Start::state) {
    start_from_state(simulation.channel());
  }
  simulation.place_for_first_stage();
  const std::int64_t most = options.steps;
  const std::int64_t left = count_steps(simulation.channel(), most);
  if (from && left == 0 && most != 0 && job.rank() == 0)
    fmt::print(
        stderr,
        "bedload-fluid: NOTE: the checkpoint is at t = {:.6g}, and 'time.end' is {}: nothing "
        "is left to do; for a longer run --set time.end=...\n",
        simulation.channel().time(), settings.time.end);
  // With a step that follows the flow the end is known in advance only by its time.
  const bool countable = settings.time.cfl == 0.0 || most >= 0;
  std::optional<LoadGroup> kept;
  if (from) kept = from->run().group(output_group);
  // What stands in the folder is the run that goes on, or to be overwritten.
  const std::int64_t kept_until = from && !options.overwrite ? simulation.channel().step() : -1;
  RunOutput<Real> output(
      options.out, simulation,
      countable ? std::optional(simulation.channel().step() + left) : std::nullopt,
      effects_of(settings, near.numbers, dem), kept ? &*kept : nullptr, kept_until);
  Checkpoints<Real> checkpoints(options.out, simulation, output, partner, from, kept_until);
  if (from) from->state.reset();
  const Advanced made = advance(simulation, output, checkpoints, options, left);
  if (made.steps <= options.warm_up && options.warm_up > 0 && job.rank() == 0)
    fmt::print(
        stderr,
        "\nbedload-fluid: NOTE: --warm-up {} is not less than the {} steps made: the table of "
        "times holds them all.\n",
        options.warm_up, made.steps);
  checkpoints.write();
  end_in_good_order();
  if (partner) partner->stop();
  output.finish(made.time_line, checkpoints.last().fluid(), options.bandwidth);
  if (!made.cut_short) return 0;
  if (job.rank() == 0)
    fmt::print(stderr,
               "\nbedload-fluid: ended after step {} (t = {:.6g}): {}; go on with --restart {}\n",
               simulation.channel().step(), simulation.channel().time(), *made.cut_short,
               checkpoints.last().folder);
  return ended_early;
}

/// --compact-state: a state for start.file in place of a run.
void compact(const FluidOptions& options, const Job& job) {
  if (!job.alone()) throw UserError("--compact-state is for bedload-fluid alone.");
  const std::string& target = options.compact[1];
  on_first_rank(job.own(), [&] {
    std::error_code error;
    if (std::filesystem::exists(target, error))
      throw UserError(
          fmt::format("--compact-state: {} is there already; name another file.", target));
  });
  write_compact_state(options.compact[0], target, job.own());
}

/// The scene's settings with those of the line, or of the run that goes on; refused where they do
/// not fit each other, the machine, the partner or that run.
Settings checked_settings(const FluidOptions& options, const Resumption* from, const Job& job) {
  Settings settings =
      read_settings(options.file, from ? from->overrides(options.settings) : options.settings);
  validate(settings);
  check_memory(settings, job);
  if (job.alone()) check_partner(settings, options);
  if (!job.alone() && options.without_grains)
    throw UserError(
        "--without-grains asks for the flow alone, but bedload-dem is in the job; leave out one of "
        "them.");
  if (from) {
    check_scene(*from, settings);
    if (job.rank() == 0)
      for (const std::string& sentence : differences(*from, settings, options.settings))
        fmt::print(stderr, "bedload-fluid: restart: {}.\n", sentence);
  }
  return settings;
}

/// Tells the partner of the scene and hears of its spheres.
PartnerScene meet(FluidSide& partner, const Settings& settings, const Resumption* from) {
  if (!settings.spheres.file.empty())
    throw UserError(fmt::format(
        "{}: 'spheres.file' is \"{}\", but with bedload-dem in the job the spheres come from its "
        "script; remove the key or start bedload-fluid alone.",
        settings.file, settings.spheres.file));
  partner.introduce(scene_info_of(settings, from), from ? from->place.grains() : std::string());
  return partner.meet();
}

int run(Job& job, int argc, char** argv) {
  const std::optional<FluidOptions> options = read_fluid_options(argc, argv, job.rank() == 0);
  if (!options) {
    if (!job.alone()) throw UserError("bedload-dem waits for a scene; ask for help without it.");
    return 0;
  }
  if (!options->compact.empty()) {
    compact(*options, job);
    return 0;
  }
  listen_to_signals();
  // A run that goes on in a folder reads what another one there may just be replacing.
  std::optional<RunLock> lock;
  on_first_rank(job.own(), [&] {
    std::error_code error;
    if (std::filesystem::is_directory(options->out, error)) lock.emplace(options->out);
  });
  std::optional<Resumption> from;
  if (!options->restart.empty()) from = open_checkpoint(options->restart, !job.alone(), job.own());
  Resumption* const resumption = from ? &*from : nullptr;
  const Settings settings = checked_settings(*options, resumption, job);
  // Before LIGGGHTS hears of the fluid: its script may write there as well.
  make_output_folder(options->out, job.own());
  on_first_rank(job.own(), [&] {
    if (!lock) lock.emplace(options->out);
    if (!options->overwrite) check_no_run_is_lost(options->out, resumption);
  });
  std::optional<FluidSide> partner;
  std::optional<PartnerScene> dem;
  if (!job.alone()) {
    partner.emplace(job);
    dem = meet(*partner, settings, resumption);
  }
  const auto start = settings.accuracy.precision == "single" ? simulate<float> : simulate<double>;
  return start(job, *options, settings, partner ? &*partner : nullptr, dem ? &*dem : nullptr,
               resumption);
}

}  // namespace
}  // namespace bedload

int main(int argc, char** argv) {
  using namespace bedload;
  flush_subnormals();
  return run_program(argc, argv, Program::fluid, exchange_protocol(),
                     [&](Job& job) { return run(job, argc, argv); });
}
