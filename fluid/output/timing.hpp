#pragma once

#include <mpi.h>

#include <string>
#include <vector>

namespace bedload {

/// Where one phase stood within a step, in seconds since its begin.
struct TimelineEntry {
  std::size_t phase;
  double start, end;
};

/// What one phase cost, over all ranks.
struct TimingRow {
  std::string part;
  double seconds_mean = 0.0;  ///< over ranks
  double seconds_max = 0.0;
  double share = 0.0;  ///< of the mean wall clock since the clock was started
  long long calls = 0;
};

/// Wall clock per named phase. Phases follow one another and do not nest; a phase costs two reads
/// of the clock. Add phases in the same order on every rank.
class Timing {
 public:
  Timing() : born_(MPI_Wtime()) {}

  /// A new phase; its number is what start() and stop() take.
  std::size_t add_phase(const std::string& name) {
    phases_.push_back({name, 0.0, 0.0, 0});
    return phases_.size() - 1;
  }
  void start(std::size_t phase) { phases_[phase].started = MPI_Wtime(); }
  void stop(std::size_t phase) {
    Phase& p = phases_[phase];
    const double now = MPI_Wtime();
    p.seconds += now - p.started;
    ++p.calls;
    if (recording_) timeline_.push_back({phase, p.started - step_began_, now - step_began_});
  }

  /// Runs `work` as one call of a phase.
  template <class Work>
  decltype(auto) measure(std::size_t phase, Work&& work) {
    const Scope scope(*this, phase);
    return work();
  }

  /// Begins to note start and end of every phase, until stop_recording() gives them back.
  void record_step() {
    timeline_.clear();
    step_began_ = MPI_Wtime();
    recording_ = true;
  }
  std::vector<TimelineEntry> stop_recording() {
    recording_ = false;
    return std::move(timeline_);
  }

  /// Forgets all that was measured, the phases' names excepted (after warming up).
  void restart();

  /// One row per phase, and a last one "rest" for what no phase saw. Collective.
  std::vector<TimingRow> reduce(MPI_Comm comm) const;

  const std::string& name(std::size_t phase) const { return phases_[phase].name; }

 private:
  struct Phase {
    std::string name;
    double seconds, started;
    long long calls;
  };
  class Scope {
   public:
    Scope(Timing& timing, std::size_t phase) : timing_(timing), phase_(phase) {
      timing_.start(phase_);
    }
    ~Scope() { timing_.stop(phase_); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    Timing& timing_;
    std::size_t phase_;
  };

  double born_, step_began_ = 0.0;
  bool recording_ = false;
  std::vector<Phase> phases_;
  std::vector<TimelineEntry> timeline_;
};

/// The rows as a table for the terminal.
std::string timing_table(const std::vector<TimingRow>& rows);

/// folder/timing.csv: part,seconds_mean_over_ranks,seconds_max,share,calls. First rank.
void write_timing(const std::string& folder, const std::vector<TimingRow>& rows);

}  // namespace bedload
