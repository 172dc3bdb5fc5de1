#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

namespace bedload {

/// How far a run is; what does not apply to it has no value.
struct ProgressState {
  std::int64_t step = 0;
  double time = 0.0, end = 0.0;           ///< [T]
  std::optional<std::int64_t> last_step;  ///< when the run ends by number of steps
  double cfl = 0.0;
  double bulk_velocity = 0.0;  ///< [L/T]
  std::optional<double> slip;  ///< largest slip of a marker [L/T]
  std::optional<std::int64_t> mobile_spheres, collisions;
};

/// "1:02:03", "2:03" or "0:03".
std::string clock_text(double seconds);

/// One line for the terminal: done is the share of the way in [0, 1], seconds_left negative while
/// unknown.
std::string progress_line(const ProgressState& state, double done, double seconds_left);

/// Shows how far a run is: one line that is redrawn on a terminal, a plain line now and then
/// elsewhere (a log file). For the first rank.
class Progress {
 public:
  /// `begin`: the state at the start of this program, to judge its speed.
  Progress(const ProgressState& begin, std::FILE* stream);

  /// Shows the state if the last one shown is old enough.
  void update(const ProgressState& state);
  /// Shows it in any case and ends the line.
  void finish(const ProgressState& state);

 private:
  void show(const ProgressState& state, double now);

  std::FILE* stream_;
  bool terminal_;
  double started_, last_shown_;
  ProgressState begin_;
};

}  // namespace bedload
