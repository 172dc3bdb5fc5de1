#include "coupling/bedload_fluid/run_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "coupling/bedload_fluid/effects.hpp"
#include "fluid/checkpoint/state_file.hpp"
#include "fluid/files/atomic_file.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/grid/diffusion_limit.hpp"
#include "fluid/output/bandwidth.hpp"
#include "fluid/output/printable.hpp"
#include "fluid/output/rhythm.hpp"
#include "fluid/output/settings_file.hpp"
#include "fluid/output/timing.hpp"
#include "fluid/poisson/fft_length.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/statistics/statistics_file.hpp"
#include "fluid/validation/derived_numbers.hpp"
#include "fluid/validation/warnings.hpp"

namespace bedload {
namespace {

constexpr const char* fixed_tags = "fixed_load_tags";  ///< in a checkpoint, parts of the ranks
constexpr const char* fixed_forces = "fixed_load_forces";

bool is_first(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank == 0;
}

/// Two warnings are one where only their numbers differ, as those of a sphere that grows.
std::string without_numbers(std::string text) {
  std::erase_if(text, [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; });
  return text;
}

}  // namespace

void make_output_folder(const std::string& folder, MPI_Comm comm) {
  on_first_rank(comm, [&] {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
      throw UserError(
          fmt::format("{}: the output folder cannot be made: {}.", folder, error.message()));
  });
}

template <class Real>
bool RunOutput<Real>::Rhythm::due(double now, double time_step) {
  if (now + 0.5 * time_step < next_) return false;
  if (every_ > 0.0) next_ = next_due(next_, every_, now + 0.5 * time_step);
  return true;
}

template <class Real>
double RunOutput<Real>::Rhythm::count(double end, double time_step, double steps) const {
  if (every_ <= time_step) return steps;
  return std::fmin(steps,
                   std::floor(std::fmax(0.0, (end + 0.5 * time_step - next_) / every_ + 1.0)));
}

template <class Real>
void RunOutput<Real>::Boundary::save(const SaveGroup& group) const {
  group.value("largest", largest);
  group.value("squares", squares);
  group.value("loops", loops_sum);
  group.value("rows", rows);
  group.value("steps", steps);
}

template <class Real>
void RunOutput<Real>::Boundary::load(const LoadGroup& group) {
  largest = group.value<double>("largest");
  squares = group.value<double>("squares");
  loops_sum = group.value<double>("loops");
  rows = group.value<std::int64_t>("rows");
  steps = group.value<std::int64_t>("steps");
}

template <class Real>
RunOutput<Real>::RunOutput(const std::string& folder, Simulation<Real>& simulation,
                           std::optional<std::int64_t> last_step,
                           const std::vector<EffectRow>& effects, const LoadGroup* resume,
                           std::int64_t kept_until)
    : folder_(folder),
      simulation_(simulation),
      settings_(simulation.channel().settings()),
      first_rank_(is_first(simulation.channel().comm())),
      first_step_(simulation.channel().step()),
      last_step_(last_step),
      effects_(effects),
      phase_(simulation.timing().add_phase("output")),
      fields_due_(settings_.output.fields_every, simulation.channel().time()),
      spheres_due_(settings_.output.spheres_every, simulation.channel().time()),
      fixed_due_(settings_.output.fixed_every, simulation.channel().time()),
      cfl_made_(simulation.channel().cfl()),
      cfl_to_come_(cfl_made_),
      fields_(folder, simulation.channel().grid(), simulation.channel().decomposition(),
              kept_until) {
  const MPI_Comm comm = simulation_.channel().comm();
  if (settings_.statistics.every > 0) {
    const Channel<Real>& channel = simulation_.channel();
    statistics_ =
        std::make_unique<Statistics<Real>>(settings_, channel.grid(), channel.decomposition());
    statistics_phase_ = simulation_.timing().add_phase("statistics");
  }
  const DerivedNumbers numbers = derive_numbers(settings_);
  if (resume) load(*resume);
  on_first_rank(comm, [&] { write_settings_file(folder_, settings_, numbers); });
  if (simulation_.may_have_spheres())
    spheres_ = std::make_unique<SphereWriter>(folder_, comm, simulation_.fixed_here(), kept_until);
  on_first_rank(comm, [&] {
    history_ = std::make_unique<History>(folder_, kept_until);
    history_step_ = history_->kept_until();  // that of the checkpoint, should no step follow
  });
  MPI_Bcast(&history_step_, 1, MPI_INT64_T, 0, comm);
  const SphereExtremes extremes = simulation_.extremes();
  if (first_rank_) {
    warn(warnings(settings_, numbers));
    warn(warnings(settings_, extremes));
    warn(warnings_of_reference(settings_, extremes));
    if (!simulation_.may_have_mobile_spheres())
      warn(warnings_without_spheres(settings_, simulation_.may_have_spheres()));
    fmt::print("{}\n\n{}\n{}\n{}", printable(settings_.title), derived_as_comments(numbers),
               effects_table(effects_), length_hints(settings_.grid.cells));
    fmt::print("{}", size_of_samples(!resume));
    progress_ = std::make_unique<Progress>(progress_state(), stdout);
  }
  if (!resume) write_spheres();
}

template <class Real>
std::string RunOutput<Real>::size_of_samples(bool start) const {
  const Channel<Real>& channel = simulation_.channel();
  const std::int64_t mobile = simulation_.mobile_count();
  if (mobile == 0 || !spheres_) return "";
  const double step = channel.time_step(), every = std::fmax(settings_.output.spheres_every, step);
  const double steps = last_step_ ? static_cast<double>(*last_step_ - channel.step())
                                  : std::round((settings_.time.end - channel.time()) / step);
  const double samples =
      (start ? 1.0 : 0.0) + spheres_due_.count(channel.time() + steps * step, step, steps);
  const double bytes = static_cast<double>(mobile) * SphereWriter::row_bytes;
  return fmt::format(
      "spheres.h5 will grow by {:.3g} MB: {} mobile spheres, {:.0f} samples of {:.3g} kB "
      "(output.spheres_every), between which a grain as fast as reference.velocity moves {:.2g} of "
      "reference.diameter\n\n",
      1e-6 * samples * bytes, mobile, samples, 1e-3 * bytes,
      every * settings_.reference.velocity / settings_.reference.diameter);
}

/// Says each of them once in a run.
template <class Real>
void RunOutput<Real>::warn(const std::vector<std::string>& sentences) {
  if (!first_rank_) return;
  for (const std::string& sentence : sentences)
    if (warned_.insert(without_numbers(sentence)).second)
      fmt::print(stderr, "bedload-fluid: WARNING: {}\n", sentence);
}

template <class Real>
void RunOutput<Real>::warn_of_new_spheres() {
  if (!simulation_.spheres_changed()) return;
  const SphereExtremes extremes = simulation_.extremes();
  warn(warnings(settings_, extremes));
  warn(warnings_of_reference(settings_, extremes));
}

template <class Real>
void RunOutput<Real>::flush() {
  if (spheres_) spheres_->flush();
}

template <class Real>
void RunOutput<Real>::save(const SaveGroup& group) const {
  fields_due_.save(group.group("fields_due"));
  spheres_due_.save(group.group("spheres_due"));
  fixed_due_.save(group.group("fixed_due"));
  boundary_.save(group.group("slip"));
  group.value("cfl", cfl_made_);
  group.value("worst_momentum_residual", worst_residual_);
  if (const auto loads = fixed_loads()) {
    std::vector<std::int64_t> tags;
    std::vector<double> forces;
    for (const SphereLoad& load : *loads) {
      tags.push_back(load.tag);
      forces.insert(forces.end(), load.force.begin(), load.force.end());
    }
    group.rows<std::int64_t>(fixed_tags, tags);
    group.rows<double>(fixed_forces, forces, 3);
  }
  if (statistics_) statistics_->save(group.group("statistics"));
}

template <class Real>
void RunOutput<Real>::load(const LoadGroup& group) {
  collectively(simulation_.channel().comm(), [&] {
    fields_due_.load(group.group("fields_due"));
    spheres_due_.load(group.group("spheres_due"));
    fixed_due_.load(group.group("fixed_due"));
    if (group.has("slip")) boundary_.load(group.group("slip"));
    if (group.has("cfl")) cfl_made_ = group.value<double>("cfl");
    worst_residual_ = group.value<double>("worst_momentum_residual");
    if (!group.has(fixed_tags)) return;
    const Part part = even_share(group.size(fixed_tags), simulation_.channel().comm());
    const auto tags = group.rows<std::int64_t>(fixed_tags, part, 1);
    const auto forces = group.rows<double>(fixed_forces, part, 3);
    fixed_loads_before_.emplace();
    for (std::size_t n = 0; n < tags.size(); ++n)
      fixed_loads_before_->push_back({.tag = tags[n], .force = Vec3(&forces[3 * n])});
  });
  if (statistics_ && group.has("statistics")) statistics_->load(group.group("statistics"));
}

template <class Real>
void RunOutput<Real>::take_statistics() {
  const Channel<Real>& channel = simulation_.channel();
  const int every = settings_.statistics.every;
  // Times are sums of steps: round-off must not cost a sample.
  const double now = channel.time() + 1e-3 * channel.last_time_step();
  if (channel.step() % every != 0 || now < settings_.statistics.from) return;
  const double duration =
      statistics_->duration_at(channel.time(), every * channel.last_time_step());
  statistics_->sample(view_of(channel), simulation_.spheres(), duration);
}

template <class Real>
void RunOutput<Real>::after_step() {
  if (statistics_) simulation_.timing().measure(statistics_phase_, [&] { take_statistics(); });
  simulation_.timing().measure(phase_, [&] {
    const Channel<Real>& channel = simulation_.channel();
    warn_of_new_spheres();
    cfl_made_ = std::exchange(cfl_to_come_, channel.cfl());
    worst_residual_ = std::fmax(worst_residual_, simulation_.momentum_residual());
    boundary_.loops_sum += channel.forcing_loops();
    ++boundary_.steps;
    if (channel.step() % settings_.output.history_every == 0) write_history();
    if (spheres_due_.due(channel.time(), channel.time_step())) write_spheres();
    if (settings_.output.fixed_every > 0.0 && fixed_due_.due(channel.time(), channel.time_step()))
      write_fixed_forces();
    if (settings_.output.fields_every > 0.0 &&
        fields_due_.due(channel.time(), channel.time_step())) {
      fields_.write(view_of(channel));
      fields_step_ = channel.step();
    }
    if (first_rank_) progress_->update(progress_state());
  });
}

template <class Real>
void RunOutput<Real>::finish(const std::string& time_line, const std::string& state,
                             bool measure_bandwidth) {
  const MPI_Comm comm = simulation_.channel().comm();
  FlowStatistics flow;
  simulation_.timing().measure(phase_, [&] {
    // A run that goes on and makes no step knows nothing of the step before it.
    const bool made_none = first_step_ > 0 && simulation_.channel().step() == first_step_;
    if (history_step_ != simulation_.channel().step() && !made_none) write_history();
    if (settings_.output.fixed_every == 0.0) write_fixed_forces();
    if (fields_step_ != simulation_.channel().step())
      fields_.write(view_of(std::as_const(simulation_).channel()));
    if (statistics_ && statistics_->samples() > 0) {
      flow = statistics_->result();
      on_first_rank(comm, [&] { write_statistics(folder_, flow); });
    }
    flush();
    on_first_rank(comm, [&] {
      commit_link(state, folder_ + "/state.h5");
      write_text_file(folder_ + "/timeline.csv", time_line);
    });
  });
  const std::vector<TimingRow> times = simulation_.timing().reduce(comm);
  const std::string effects = effects_table(effects_with_shares(times));
  const std::vector<PhaseRow> phase_times = phases();
  const double bandwidth = measure_bandwidth ? triad_bandwidth(comm) : 0.0;
  on_first_rank(comm, [&] {
    write_timing(folder_, times);
    write_phases(folder_, phase_times, bandwidth);
    progress_->finish(progress_state());
    if (flow.samples > 0) fmt::print("\n{}", statistics_summary(flow));
    fmt::print("\n{}\n{}\n{}\n{}Output: {}\n", timing_table(times),
               phase_table(phase_times, bandwidth), effects, slip_summary(), folder_);
    warn_of_slip();
  });
}

/// In reference.velocity; 0 where there are no spheres, or nothing has been measured.
template <class Real>
double RunOutput<Real>::slip_rms() const {
  if (!simulation_.channel().immersed_boundary() || boundary_.rows == 0) return 0.0;
  return std::sqrt(boundary_.squares / static_cast<double>(boundary_.rows)) /
         settings_.reference.velocity;
}

template <class Real>
std::string RunOutput<Real>::slip_summary() const {
  if (!simulation_.channel().immersed_boundary() || boundary_.rows == 0 || boundary_.steps == 0)
    return "";
  return fmt::format(
      "No-slip error at the markers over the run, in reference.velocity: {:.3g} (root mean "
      "square), {:.3g} (largest); {:.3g} forcing loops a stage.\n\n",
      slip_rms(), boundary_.largest / settings_.reference.velocity,
      boundary_.loops_sum / static_cast<double>(boundary_.steps));
}

template <class Real>
void RunOutput<Real>::warn_of_slip() const {
  // Of touching fixed spheres at D/h = 8 the drag is right within 2 % with 0.13 (simple cubic), 16
  // % too small with 0.46 (body-centred) and 51 % with 0.79 (face-centred): slip_rms in history.csv
  // of
  // `./bedload study validation array packing`.
  constexpr double most = 0.25;
  if (const double slip = slip_rms(); slip > most && boundary_.steps > 0)
    fmt::print(
        stderr,
        "bedload-fluid: WARNING: the no-slip error of {:.2g} reference.velocity is large: "
        "fluid passes through the spheres' surfaces. More 'spheres.forcing_loops' or smaller "
        "cells help (or 'reference.velocity' is not that of the flow).\n",
        slip);
}

template <class Real>
std::vector<EffectRow> RunOutput<Real>::effects_with_shares(
    std::span<const TimingRow> times) const {
  const Channel<Real>& channel = simulation_.channel();
  MarkerSeconds mine;
  if (channel.immersed_boundary()) mine = channel.immersed_boundary()->seconds();
  std::array<double, 4> sums{mine.placing, mine.first_loops, mine.extra_loops, mine.interior};
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 4, MPI_DOUBLE, MPI_SUM, channel.comm());
  for (double& sum : sums) sum /= channel.decomposition().ranks();
  std::vector<EffectRow> effects = effects_;
  add_shares(effects, times, {sums[0], sums[1], sums[2], sums[3]}, simulation_.grain_seconds());
  return effects;
}

template <class Real>
std::vector<PhaseRow> RunOutput<Real>::phases() const {
  const Channel<Real>& channel = simulation_.channel();
  return phase_rows(channel.clock(),
                    {.cells = channel.grid().cell_count(),
                     .stages = 3.0 * static_cast<double>(channel.step() - first_step_),
                     .real_bytes = sizeof(Real),
                     .old_pressure = channel.immersed_boundary() != nullptr,
                     .implicit_diffusion = diffusion_is_implicit(settings_, channel.grid())},
                    channel.comm());
}

template <class Real>
void RunOutput<Real>::write_spheres() {
  if (!spheres_) return;
  const Channel<Real>& channel = simulation_.channel();
  spheres_->sample(channel.step(), channel.time(), simulation_.mobile_here(),
                   simulation_.mean_loads());
}

template <class Real>
std::optional<std::vector<SphereLoad>> RunOutput<Real>::fixed_loads() const {
  const bool no_step_yet = simulation_.channel().step() == first_step_;
  return no_step_yet ? fixed_loads_before_ : simulation_.fixed_loads();
}

template <class Real>
void RunOutput<Real>::write_fixed_forces() {
  const Channel<Real>& channel = simulation_.channel();
  const auto loads = fixed_loads();
  if (spheres_ && loads)
    spheres_->sample_fixed(channel.step(), channel.time(), simulation_.fixed_here(), *loads,
                           settings_.output.fixed_every == 0.0);
}

template <class Real>
void RunOutput<Real>::write_history() {
  const HistoryRow row = history_row();
  if (first_rank_) history_->add(row);
  boundary_.largest = std::max(boundary_.largest, row.slip_max);
  boundary_.squares += row.slip_rms * row.slip_rms;
  ++boundary_.rows;
  worst_residual_ = 0.0;
  history_step_ = row.step;
}

template <class Real>
HistoryRow RunOutput<Real>::history_row() const {
  Channel<Real>& channel = simulation_.channel();
  const Slip slip = channel.slip();
  const bool no_residual = std::isnan(simulation_.momentum_residual());
  const double driving = channel.driving_force();
  const std::array<double, 2> wall_stress = channel.wall_stress();
  const std::array<double, 2> grain_stress = simulation_.grain_stress();
  const Vec3 on_fixed = simulation_.fixed_force();
  const EnergyWork work = simulation_.energy_work();
  const double density = settings_.fluid.density;
  return {
      .step = channel.step(),
      .time = channel.time(),
      .dt = channel.last_time_step(),
      .cfl = cfl_made_,
      .bulk_velocity = channel.bulk_velocity(),
      .driving = driving,
      .kinetic_energy = channel.kinetic_energy() / channel.grid().volume(),
      .dissipation = (channel.viscous_loss() + channel.wall_power()) / channel.grid().volume(),
      .forcing_work = density * work.forcing,
      .viscous_work = density * work.viscous,
      .convective_work = density * work.convective,
      .u_tau_driving = u_tau_of_driving(driving, settings_),
      .wall_stress_lower = wall_stress[0],
      .wall_stress_upper = wall_stress[1],
      .grain_stress_lower = grain_stress[0],
      .grain_stress_upper = grain_stress[1],
      .max_divergence = channel.max_divergence(),
      .slip_max = slip.max,
      .slip_rms = slip.rms,
      .forcing_loops = channel.forcing_loops(),
      .mobile_spheres = simulation_.mobile_count(),
      .momentum_residual = no_residual ? std::numeric_limits<double>::quiet_NaN() : worst_residual_,
      .fixed_force_x = on_fixed.x(),
      .fixed_force_y = on_fixed.y(),
      .fixed_force_z = on_fixed.z()};
}

template <class Real>
ProgressState RunOutput<Real>::progress_state() const {
  const Channel<Real>& channel = simulation_.channel();
  ProgressState state;
  state.step = channel.step();
  state.time = channel.time();
  state.end = settings_.time.end;
  state.last_step = last_step_;
  state.cfl = channel.cfl();
  state.bulk_velocity = channel.bulk_velocity();
  if (spheres_) state.mobile_spheres = simulation_.mobile_count();
  if (simulation_.collisions() >= 0) state.collisions = simulation_.collisions();
  return state;
}

template class RunOutput<float>;
template class RunOutput<double>;

}  // namespace bedload
