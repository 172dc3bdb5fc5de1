#include "coupling/checkpoint/checkpoints.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <random>
#include <sstream>
#include <utility>

#include "coupling/exchange/clock.hpp"
#include "coupling/job/peer_failure.hpp"
#include "coupling/job/signals.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/kernels/fnv.hpp"
#include "fluid/output/rhythm.hpp"
#include "fluid/poisson/fftw.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

// Groups and datasets of the fluid's half.
constexpr const char* channel_group = "channel";
constexpr const char* spheres_group = "spheres";
constexpr const char* wisdom_name = "fftw_wisdom";
constexpr const char* y_cuts_name = "y_cuts";
constexpr const char* z_cuts_name = "z_cuts";
constexpr const char* step_name = "time_step";
constexpr const char* settings_name = "settings";
constexpr const char* overrides_name = "overrides";
constexpr const char* fixed_name = "fixed_spheres";
constexpr const char* every_name = "checkpoint_every";
constexpr const char* next_name = "checkpoint_next";

/// Once a step a part of each impulse comes later (ImmersedBoundary::reaction_share). What is owed
/// when the rule changes is the spheres' momentum: none of it may be forgotten or made up.
constexpr const char* other_exchange =
    "; the mobile spheres get the fluid's impulses at other times now: in the first five steps or "
    "so drag and lift are wrong, at first by half and more, and speeds jump by some per cent";

std::vector<CheckpointPlace> all_of_run(const CheckpointPlace& place) {
  return find_checkpoints(std::filesystem::path(place.folder).parent_path().string());
}

bool has_grains(const CheckpointPlace& place) {
  std::error_code error;
  return std::filesystem::exists(place.grains(), error);
}

/// A run goes on with the programs that it had. One checkpoint alone may have lost a half.
void check_programs(const CheckpointPlace& place, bool with_grains, MPI_Comm comm) {
  on_first_rank(comm, [&] {
    const auto all = all_of_run(place);
    const bool had_grains = std::any_of(all.begin(), all.end(), has_grains);
    if (with_grains && !had_grains)
      throw UserError(fmt::format(
          "{}: is of a run without LIGGGHTS; go on with bedload-fluid alone.", place.folder));
    if (!with_grains && had_grains)
      throw UserError(
          fmt::format("{}: is of a run with LIGGGHTS; go on with both programs.", place.folder));
  });
}

void check_parts(const CheckpointPlace& place, const LoadGroup& fluid, bool with_grains,
                 MPI_Comm comm) {
  on_first_rank(comm, [&] {
    if (with_grains && !has_grains(place))
      throw UserError(fmt::format("{}: LIGGGHTS' half is not there.", place.grains()));
  });
  if (!with_grains) return;
  check_file_header(place.grains(), grains_file_header, comm);
  on_first_rank(comm, [&] {
    const Hdf5File file(place.grains(), Hdf5File::Access::read, MPI_COMM_SELF);
    const LoadGroup grains(file, grains_group);
    const auto step = grains.value<std::int64_t>("fluid_step");
    if (step != place.step)
      throw UserError(
          fmt::format("{}: holds the grains of fluid step {}, not what the name of its "
                      "folder says.",
                      place.grains(), step));
    if (grains.value<std::int64_t>(id_name) != fluid.value<std::int64_t>(id_name))
      throw UserError(fmt::format(
          "{}: is not the other half of {}; two runs have written there, or files were exchanged.",
          place.grains(), place.fluid()));
  });
}

Resumption read_checkpoint(const CheckpointPlace& place, bool with_grains, MPI_Comm comm) {
  const auto state = std::make_shared<const StateReader>(place.fluid(), comm);
  collectively(comm, [&] {
    if (!state->has_run())
      throw UserError(
          fmt::format("{}: is {} and no checkpoint{}; it serves as start.file.", place.fluid(),
                      state->has_run_of_old() ? "a flow of an earlier version" : "a start field",
                      state->has_run_of_old() ? " that this one reads" : ""));
    if (state->header().step != place.step)
      throw UserError(fmt::format("{}: holds step {}, not what the name of its folder says.",
                                  place.fluid(), state->header().step));
  });
  check_parts(place, state->run(), with_grains, comm);
  return {place, state->header(), state};
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string key_of(const std::string& override_) {
  const std::string key = override_.substr(0, override_.find('='));
  return key.substr(0, key.find_last_not_of(' ') + 1);
}

/// Number of the fixed spheres, their places and sizes, and these with their tags: what is kept of
/// one goes by its tag, the line of a sphere file.
std::array<std::int64_t, 3> fingerprint_of_fixed(std::span<const SphereState> spheres) {
  std::array<std::int64_t, 3> all{};
  for (const SphereState& sphere : spheres) {
    if (sphere.mobile) continue;
    std::uint64_t hash = fnv_start;
    for (const double number :
         {sphere.position[0], sphere.position[1], sphere.position[2], sphere.radius})
      hash = fnv_mixed(hash, std::bit_cast<std::uint64_t>(number));
    ++all[0];
    all[1] ^= std::bit_cast<std::int64_t>(hash);
    all[2] ^= std::bit_cast<std::int64_t>(fnv_mixed(hash, static_cast<std::uint64_t>(sphere.tag)));
  }
  return all;
}

/// A number that no other checkpoint has: halves that belong together show it. Collective.
std::int64_t draw_id(MPI_Comm comm) {
  std::random_device source;
  std::int64_t id = (static_cast<std::int64_t>(source() >> 1) << 32) | source();
  MPI_Bcast(&id, 1, MPI_INT64_T, 0, comm);
  return id;
}

/// What to do when `place` cannot be read: the newest whole checkpoint before it, else one behind
/// it, else a new run.
std::string way_out(const CheckpointPlace& place, bool with_grains, MPI_Comm comm) {
  auto all = all_of_run(place);
  std::reverse(all.begin(), all.end());
  std::stable_partition(all.begin(), all.end(),
                        [&](const CheckpointPlace& other) { return other.step < place.step; });
  for (const CheckpointPlace& other : all) {
    if (other.step == place.step) continue;
    try {
      read_checkpoint(other, with_grains, comm);
      return fmt::format("The one {} it is whole: --restart {}",
                         other.step < place.step ? "before" : "behind", other.folder);
    } catch (const UserError&) {  // then the next one
    }
  }
  const auto flow = std::filesystem::path(place.folder).parent_path() / "state.h5";
  try {
    const StateReader last(flow.string(), comm);
    return fmt::format(
        "The run has no other one that can be read; a new run can begin with its last flow: --set "
        "start.from=state --set start.file={}",
        flow.string());
  } catch (const UserError&) {
    return "The run has no other one that can be read; begin a new run.";
  }
}

}  // namespace

Cuts Resumption::cuts(int ranks, const Settings& settings) const {
  const Cuts cuts{.y = run().list<std::int32_t>(y_cuts_name),
                  .z = run().list<std::int32_t>(z_cuts_name)};
  const bool fits = !cuts.y.empty() && !cuts.z.empty() &&
                    cuts.y_parts() * cuts.z_parts() == ranks &&
                    (settings.ranks.along_z == 0 || settings.ranks.along_z == cuts.z_parts());
  return fits ? cuts : Cuts{};
}

double Resumption::time_step() const { return run().value<double>(step_name); }

std::vector<std::string> Resumption::overrides(const std::vector<std::string>& now) const {
  std::vector<std::string> all = lines_of(run().text(overrides_name));
  for (const std::string& word : now) {
    std::erase_if(all, [&](const std::string& old) { return key_of(old) == key_of(word); });
    all.push_back(word);
  }
  return all;
}

std::vector<std::string> differences(const Resumption& from, const Settings& settings,
                                     const std::vector<std::string>& now) {
  std::vector<std::string> sentences;
  for (const std::string& word : settings.overrides)
    if (std::find(now.begin(), now.end(), word) == now.end())
      sentences.push_back(fmt::format("--set {} of the run before holds", word));
  std::map<std::string, std::string> before;
  for (const std::string& line : lines_of(from.run().text(settings_name)))
    before[line.substr(0, line.find(" = "))] = line.substr(line.find(" = ") + 3);
  for (const auto& [key, value] : settings_as_pairs(settings))
    if (const auto old = before.find(key); old != before.end() && old->second != value)
      sentences.push_back(
          fmt::format("'{}' is {}, in the run before {}{}", key, value, old->second,
                      key == "coupling.exchange" && has_grains(from.place) ? other_exchange : ""));
  return sentences;
}

void check_fixed_spheres(const Resumption& from, std::span<const SphereState> spheres) {
  const auto before = from.run().list<std::int64_t>(fixed_name);
  const auto now = fingerprint_of_fixed(spheres);
  // An earlier version kept no tags.
  if (before.size() <= now.size() && std::equal(before.begin(), before.end(), now.begin())) return;
  if (before.at(1) == now[1])
    throw UserError(fmt::format(
        "{}: 'spheres.file' has the fixed spheres of the run before in another order now; a run "
        "that goes on knows each by its line.",
        from.place.fluid()));
  throw UserError(fmt::format(
      "{}: the run before had {} fixed spheres, and 'spheres.file' has {}{} now; a run goes on "
      "with "
      "the same, and another one starts from this flow with 'start.file'.",
      from.place.fluid(), before.at(0), now[0], before.at(0) == now[0] ? " others" : ""));
}

Resumption open_checkpoint(const std::string& where, bool with_grains, MPI_Comm comm) {
  const CheckpointPlace place = locate_checkpoint(where);
  check_programs(place, with_grains, comm);
  try {
    return read_checkpoint(place, with_grains, comm);
  } catch (const UserError& error) {
    throw UserError(fmt::format("{} {}", error.what(), way_out(place, with_grains, comm)));
  }
}

void check_scene(const Resumption& from, const Settings& settings) {
  const auto refuse = [&](const char* key, const auto& found, const auto& wanted) {
    throw UserError(fmt::format(
        "{}: was written with '{}' {}, but {} has {}; a run goes on with the same, and another one "
        "starts from this flow with 'start.file'.",
        from.place.fluid(), key, found, settings.file, wanted));
  };
  if (from.header.cells != settings.grid.cells)
    refuse("grid.cells", from.header.cells, settings.grid.cells);
  for (std::size_t d = 0; d < 3; ++d)
    if (std::abs(from.header.length[d] - settings.grid.length[d]) > 1e-9 * settings.grid.length[d])
      refuse("grid.length", from.header.length, settings.grid.length);
  if (!same_cells(from.header, make_grid(settings)))
    throw UserError(fmt::format(
        "{}: its planes have other heights than 'grid.y_stretching' and 'grid.y_uniform' of {} "
        "give; "
        "a run goes on with the same, and another one starts from this flow with 'start.file'.",
        from.place.fluid(), settings.file));
}

void learn_transforms(const Resumption& from) { learn_all(from.run().text(wisdom_name)); }

template <class Real>
void restore_flow(const Resumption& from, Channel<Real>& channel) {
  read_state(*from.state, channel.grid(), channel.decomposition(), channel.fields_to_restore());
  channel.restored(from.header.time, from.header.step, from.header.driving, false);
  collectively(channel.comm(), [&] { channel.load(from.run().group(channel_group)); });
  if (auto* const boundary = channel.immersed_boundary(); boundary && from.run().has(spheres_group))
    boundary->load(from.run().group(spheres_group));
}

template <class Real>
Checkpoints<Real>::Checkpoints(const std::string& out, Simulation<Real>& simulation,
                               RunOutput<Real>& output, FluidSide* partner, const Resumption* from,
                               std::int64_t kept_until)
    : out_(out),
      simulation_(simulation),
      output_(output),
      partner_(partner),
      settings_(simulation.channel().settings()),
      phase_(simulation.timing().add_phase("checkpoints")),
      began_(clock_seconds()),
      written_(began_),
      next_time_(simulation.channel().time() + settings_.checkpoint.every) {
  if (from) {
    last_ = from->place;
    name_checkpoint(last_.folder);
    if (from->run().value<double>(every_name) == settings_.checkpoint.every)
      next_time_ = from->run().value<double>(next_name);
  }
  on_first_rank(simulation_.channel().comm(), [&] {
    discard_checkpoint(out_);
    forget_checkpoints_after(out_, kept_until);
  });
}

template <class Real>
typename Checkpoints<Real>::Due Checkpoints<Real>::find_due(int& signal) {
  const Channel<Real>& channel = simulation_.channel();
  Due due = Due::nothing;
  switch (take_wish(signal)) {
    case Wish::none:
      break;
    case Wish::checkpoint:
      due = Due::checkpoint;
      break;
    case Wish::end:
      due = Due::end_by_signal;
  }
  if (due == Due::nothing) {
    const double now = clock_seconds();
    const bool by_time = settings_.checkpoint.every > 0.0 &&
                         channel.time() + 0.5 * channel.time_step() >= next_time_;
    const bool by_clock =
        settings_.checkpoint.wall_every > 0.0 && now - written_ >= settings_.checkpoint.wall_every;
    if (by_time || by_clock) due = Due::checkpoint;
    if (settings_.time.wall_limit > 0.0 && now - began_ >= settings_.time.wall_limit)
      due = Due::end_by_limit;
  }
  std::array<int, 2> strongest{static_cast<int>(due), signal};
  MPI_Allreduce(MPI_IN_PLACE, strongest.data(), 2, MPI_INT, MPI_MAX, channel.comm());
  signal = strongest[1];
  return static_cast<Due>(strongest[0]);
}

template <class Real>
std::optional<std::string> Checkpoints<Real>::after_step() {
  int signal = 0;
  const Due due = find_due(signal);
  if (due == Due::nothing) return std::nullopt;
  write();
  if (due == Due::checkpoint) return std::nullopt;
  return due == Due::end_by_limit
             ? fmt::format("time.wall_limit ({} s) is reached", settings_.time.wall_limit)
             : fmt::format("signal {} ({})", signal, strsignal(signal));
}

template <class Real>
void Checkpoints<Real>::write() {
  Channel<Real>& channel = simulation_.channel();
  if (last_.step == channel.step()) return;
  if (settings_.checkpoint.every > 0.0)
    next_time_ = next_due(next_time_, settings_.checkpoint.every,
                          channel.time() + 0.5 * channel.time_step());
  simulation_.timing().measure(phase_, [&] {
    const MPI_Comm comm = channel.comm();
    output_.flush();
    simulation_.renew_spheres();
    channel.renew_ghosts();
    std::string folder;
    on_first_rank(comm, [&] { begin_checkpoint(out_); });
    const CheckpointPlace part{std::filesystem::absolute(out_ + "/checkpoint.part").string(),
                               channel.step()};
    bool confirmed = false;
    try {
      const std::int64_t id = draw_id(comm);
      if (partner_) partner_->order_checkpoint(part.grains(), id);
      write_state(part.fluid(), view_of(std::as_const(channel)), [&](const SaveGroup& run) {
        run.value(id_name, id);
        save(run);
      });
      if (partner_) partner_->await_checkpoint();
      confirmed = true;
      on_first_rank(comm, [&] { commit_checkpoint(out_, channel.step()); });
    } catch (const UserError&) {
      // LIGGGHTS may still be writing there, or may have ended the job with a sentence of its own.
      if (partner_ && !confirmed) partner_->await_checkpoint();
      if (channel.decomposition().rank() == 0) discard_checkpoint(out_);
      throw;
    }
  });
  last_ = checkpoint_place(out_, channel.step());
  name_checkpoint(std::filesystem::absolute(last_.folder).lexically_normal().string());
  written_ = clock_seconds();
}

template <class Real>
void Checkpoints<Real>::save(const SaveGroup& run) const {
  const Channel<Real>& channel = simulation_.channel();
  channel.save(run.group(channel_group));
  if (channel.immersed_boundary()) channel.immersed_boundary()->save(run.group(spheres_group));
  output_.save(run.group(output_group));
  run.value(step_name, channel.time_step());
  std::string text;
  for (const auto& [key, value] : settings_as_pairs(settings_))
    text += fmt::format("{} = {}\n", key, value);
  run.text(settings_name, text);
  run.text(overrides_name, fmt::format("{}", fmt::join(settings_.overrides, "\n")));
  std::array<std::int64_t, 3> fixed = fingerprint_of_fixed(simulation_.fixed_here());
  MPI_Allreduce(MPI_IN_PLACE, &fixed[0], 1, MPI_INT64_T, MPI_SUM, run.comm());
  MPI_Allreduce(MPI_IN_PLACE, &fixed[1], 2, MPI_INT64_T, MPI_BXOR, run.comm());
  run.list<std::int64_t>(fixed_name, fixed);
  run.value(every_name, settings_.checkpoint.every);
  run.value(next_name, next_time_);
  const Cuts& cuts = channel.decomposition().cuts();
  run.list<std::int32_t>(y_cuts_name, cuts.y);
  run.list<std::int32_t>(z_cuts_name, cuts.z);
  // What FFTW has learned on the first rank is all that any rank has (plan_alike).
  run.text(wisdom_name, all_wisdom());
}

template void restore_flow(const Resumption&, Channel<float>&);
template void restore_flow(const Resumption&, Channel<double>&);
template class Checkpoints<float>;
template class Checkpoints<double>;

}  // namespace bedload
