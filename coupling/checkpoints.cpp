#include "coupling/checkpoints.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "coupling/clock.hpp"
#include "coupling/signals.hpp"
#include "coupling/survivors.hpp"
#include "fluid/errors.hpp"
#include "fluid/fftw.hpp"
#include "fluid/output/agreement.hpp"
#include "fluid/output/rhythm.hpp"

namespace bedload {
namespace {

// Names of the lists that travel with the flow.
constexpr const char* numbers_name = "running_numbers";
constexpr const char* y_cuts_name = "y_cuts";
constexpr const char* z_cuts_name = "z_cuts";
constexpr const char* interior_name = "interior";
constexpr const char* wisdom_name = "fftw_wisdom";
constexpr const char* step_name = "time_step";
constexpr const char* due_name = "checkpoint_due";

/// What FFTW has learned on the first rank, which is all that any rank has (plan_alike), as
/// numbers; what goes into the file has to be the same everywhere. Collective.
template <class Real>
std::vector<double> transform_wisdom(MPI_Comm comm) {
  const std::string text = wisdom_in_order<Real>();
  std::vector<double> numbers(text.begin(), text.end());
  int length = static_cast<int>(numbers.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, comm);
  numbers.resize(static_cast<std::size_t>(length));
  MPI_Bcast(numbers.data(), length, MPI_DOUBLE, 0, comm);
  return numbers;
}

const std::vector<double>& list_of(const StateExtras& extras, const char* name) {
  static const std::vector<double> nothing;
  const auto found = extras.find(name);
  return found == extras.end() ? nothing : found->second;
}

void check_parts(const CheckpointPlace& place, bool with_grains, MPI_Comm comm) {
  on_first_rank(comm, [&] {
    const bool has_grains = std::filesystem::exists(place.grains());
    if (with_grains && !has_grains)
      throw UserError(fmt::format(
          "{}: is of a run without LIGGGHTS; go on with bedload-fluid alone.", place.folder));
    if (!with_grains && has_grains)
      throw UserError(
          fmt::format("{}: is of a run with LIGGGHTS; go on with both programs.", place.folder));
  });
  if (!with_grains) return;
  check_front_block(place.grains(), grains_front, comm);
  on_first_rank(comm, [&] {
    std::ifstream file(place.grains(), std::ios::binary);
    file.seekg(static_cast<std::streamoff>(front_block_bytes));
    std::int64_t step = -1;  // what LIGGGHTS writes first (grains_state.cpp)
    file.read(reinterpret_cast<char*>(&step), sizeof step);
    if (step != place.step)
      throw UserError(
          fmt::format("{}: holds the grains of fluid step {}, not what the name of its "
                      "folder says.",
                      place.grains(), step));
  });
}

Resumption read_checkpoint(const CheckpointPlace& place, bool with_grains, MPI_Comm comm) {
  const StateReader state(place.fluid(), comm);
  check_parts(place, with_grains, comm);
  Resumption from{place, state.header(), {}};
  together(comm, [&] {
    from.extras = state.extras();
    if (list_of(from.extras, numbers_name).empty())
      throw UserError(fmt::format(
          "{}: is a start field and no checkpoint; it serves as start.file.", place.fluid()));
    if (from.header.step != place.step)
      throw UserError(fmt::format("{}: holds step {}, not what the name of its folder says.",
                                  place.fluid(), from.header.step));
  });
  return from;
}

/// The newest whole checkpoint before `place`.
std::optional<CheckpointPlace> one_before(const CheckpointPlace& place, bool with_grains,
                                          MPI_Comm comm) {
  auto all = find_checkpoints(std::filesystem::path(place.folder).parent_path().string());
  std::reverse(all.begin(), all.end());
  for (const CheckpointPlace& other : all) {
    if (other.step >= place.step) continue;
    try {
      read_checkpoint(other, with_grains, comm);
      return other;
    } catch (const UserError&) {  // then the one before that
    }
  }
  return std::nullopt;
}

}  // namespace

Cuts Resumption::cuts(int ranks, const Settings& settings) const {
  const auto kept = [this](const char* name) {
    const std::vector<double>& list = list_of(extras, name);
    return std::vector<int>(list.begin(), list.end());
  };
  Cuts cuts{.y = kept(y_cuts_name), .z = kept(z_cuts_name)};
  const bool fits = !cuts.y.empty() && !cuts.z.empty() &&
                    cuts.y_parts() * cuts.z_parts() == ranks &&
                    (settings.ranks.along_z == 0 || settings.ranks.along_z == cuts.z_parts());
  return fits ? cuts : Cuts{};
}

double Resumption::time_step() const { return list_of(extras, step_name).at(0); }

Resumption open_checkpoint(const std::string& where, bool with_grains, MPI_Comm comm) {
  const CheckpointPlace place = locate_checkpoint(where);
  try {
    return read_checkpoint(place, with_grains, comm);
  } catch (const UserError& error) {
    const auto other = one_before(place, with_grains, comm);
    if (!other) throw;
    throw UserError(
        fmt::format("{} The one before it is whole: --restart {}", error.what(), other->folder));
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

template <class Real>
void learn_transforms(const Resumption& from) {
  const std::vector<double>& kept = list_of(from.extras, wisdom_name);
  std::string wisdom;
  for (const double letter : kept) wisdom.push_back(static_cast<char>(letter));
  if (!wisdom.empty()) Fftw<Real>::learn(wisdom.c_str());
}

template <class Real>
void restore_flow(const Resumption& from, Channel<Real>& channel) {
  const StateRead state = read_state(from.place.fluid(), channel.grid(), channel.decomposition(),
                                     channel.velocity_to_restore(), channel.pressure_to_restore());
  channel.restored(state.header.time, state.header.step, state.header.driving, false);
  channel.set_running_numbers(list_of(from.extras, numbers_name));
  if (auto* const boundary = channel.immersed_boundary())
    boundary->set_remembered(list_of(from.extras, interior_name));
}

template <class Real>
Checkpoints<Real>::Checkpoints(const std::string& out, Simulation<Real>& simulation,
                               RunOutput<Real>& output, FluidSide* partner, const Resumption* from)
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
    const std::vector<double>& due = list_of(from->extras, due_name);
    if (due.size() == 2 && due[0] == settings_.checkpoint.every) next_time_ = due[1];
  }
  on_first_rank(simulation_.channel().comm(), [&] {
    discard_checkpoint(out_);
    forget_checkpoints_after(out_, from ? from->header.step : -1);
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
    channel.renew_ghosts();
    std::string folder;
    on_first_rank(comm, [&] { begin_checkpoint(out_); });
    const CheckpointPlace part{std::filesystem::absolute(out_ + "/checkpoint.part").string(),
                               channel.step()};
    bool confirmed = false;
    try {
      if (partner_) partner_->order_checkpoint(part.grains());
      write_state(part.fluid(), view_of(std::as_const(channel)), extras());
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
StateExtras Checkpoints<Real>::extras() const {
  const Channel<Real>& channel = simulation_.channel();
  StateExtras extras;
  output_.put_into(extras);
  extras[numbers_name] = channel.running_numbers();
  extras[step_name] = {channel.time_step()};
  extras[due_name] = {settings_.checkpoint.every, next_time_};
  const Cuts& cuts = channel.decomposition().cuts();
  extras[y_cuts_name] = {cuts.y.begin(), cuts.y.end()};
  extras[z_cuts_name] = {cuts.z.begin(), cuts.z.end()};
  if (channel.immersed_boundary())
    extras[interior_name] = channel.immersed_boundary()->remembered();
  extras[wisdom_name] = transform_wisdom<Real>(channel.comm());
  return extras;
}

template void learn_transforms<float>(const Resumption&);
template void learn_transforms<double>(const Resumption&);
template void restore_flow(const Resumption&, Channel<float>&);
template void restore_flow(const Resumption&, Channel<double>&);
template class Checkpoints<float>;
template class Checkpoints<double>;

}  // namespace bedload
