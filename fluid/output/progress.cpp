#include "fluid/output/progress.hpp"

#include <fmt/format.h>
#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace bedload {
namespace {

constexpr double redraw_seconds = 0.2, log_seconds = 10.0;

/// Share of the way from `begin` to the run's end that `state` has gone; by steps when they end it
/// sooner.
double share_done(const ProgressState& begin, const ProgressState& state) {
  const double by_time =
      state.end > begin.time ? (state.time - begin.time) / (state.end - begin.time) : 1.0;
  if (!state.last_step) return std::clamp(by_time, 0.0, 1.0);
  const auto steps = static_cast<double>(*state.last_step - begin.step);
  const double by_step = steps > 0 ? static_cast<double>(state.step - begin.step) / steps : 1.0;
  return std::clamp(std::max(by_time, by_step), 0.0, 1.0);
}

/// Whether a line may be drawn over. mpirun gives every rank a terminal of its own, whatever its
/// output goes to, so that isatty alone tells nothing: without TERM, or with TERM=dumb, it is a
/// log.
bool rewrites_lines(std::FILE* stream) {
  const char* const term = std::getenv("TERM");
  return ::isatty(::fileno(stream)) != 0 && term != nullptr && std::string_view(term) != "dumb";
}

}  // namespace

std::string clock_text(double seconds) {
  const auto whole = static_cast<long long>(std::llround(seconds));
  const long long hours = whole / 3600, minutes = whole / 60 % 60, rest = whole % 60;
  return hours > 0 ? fmt::format("{}:{:02}:{:02}", hours, minutes, rest)
                   : fmt::format("{}:{:02}", minutes, rest);
}

std::string progress_line(const ProgressState& s, double done, double seconds_left) {
  constexpr int width = 20;
  const int full = static_cast<int>(done * width);
  std::string line = fmt::format("[{:#<{}}{:.<{}}] {:3.0f}%  ", "", full, "", width - full,
                                 std::floor(100.0 * done));
  line += seconds_left >= 0.0 ? fmt::format("{} left  ", clock_text(seconds_left)) : "- left  ";
  line += s.last_step ? fmt::format("step {}/{}", s.step, *s.last_step)
                      : fmt::format("step {}", s.step);
  line += fmt::format("  t {:.4g}/{:.4g}  CFL {:.2f}  u_b {:.4g}", s.time, s.end, s.cfl,
                      s.bulk_velocity);
  if (s.slip) line += fmt::format("  slip {:.1e}", *s.slip);
  if (s.mobile_spheres) line += fmt::format("  mobile {}", *s.mobile_spheres);
  if (s.collisions) line += fmt::format("  collisions {}", *s.collisions);
  return line;
}

Progress::Progress(const ProgressState& begin, std::FILE* stream)
    : stream_(stream),
      terminal_(rewrites_lines(stream)),
      started_(MPI_Wtime()),
      last_shown_(started_),
      begin_(begin) {}

void Progress::update(const ProgressState& state) {
  const double now = MPI_Wtime();
  if (now - last_shown_ >= (terminal_ ? redraw_seconds : log_seconds)) show(state, now);
}

void Progress::finish(const ProgressState& state) {
  show(state, MPI_Wtime());
  if (terminal_) fmt::print(stream_, "\n");
  std::fflush(stream_);
}

void Progress::show(const ProgressState& state, double now) {
  last_shown_ = now;
  const double done = share_done(begin_, state);
  const double left = done > 0.0 ? (now - started_) * (1.0 - done) / done : -1.0;
  const std::string line = progress_line(state, done, left);
  // Back to the begin of the line, and clear what a longer one left behind.
  if (terminal_)
    fmt::print(stream_, "\r{}\x1b[K", line);
  else
    fmt::print(stream_, "{}\n", line);
  std::fflush(stream_);
}

}  // namespace bedload
