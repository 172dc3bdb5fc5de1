#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "coupling/bedload_fluid/simulation.hpp"
#include "fluid/checkpoint/group.hpp"
#include "fluid/output/effects_table.hpp"
#include "fluid/output/field_writer.hpp"
#include "fluid/output/history.hpp"
#include "fluid/output/phase_table.hpp"
#include "fluid/output/progress.hpp"
#include "fluid/output/sphere_writer.hpp"
#include "fluid/settings/settings.hpp"
#include "fluid/statistics/statistics.hpp"

namespace bedload {

/// Makes the folder of a run's output where it is missing. Collective; throws UserError.
void make_output_folder(const std::string& folder, MPI_Comm comm);

/// Everything that a run shows and leaves behind: the folder OUT and the terminal. Collective over
/// the fluid's ranks; the first one writes tables and prints.
template <class Real>
class RunOutput {
 public:
  /// Writes settings.toml and the spheres at the start into a folder that exists, prints the
  /// effects. `last_step`: where it is known in advance. With `resume` the run goes on from an
  /// earlier one. Files that stand in the folder are continued behind the step `kept_until`; -1:
  /// they begin anew.
  RunOutput(const std::string& folder, Simulation<Real>& simulation,
            std::optional<std::int64_t> last_step, const std::vector<EffectRow>& effects,
            const LoadGroup* resume, std::int64_t kept_until);

  /// After each step: what is due.
  void after_step();

  /// Puts what is held back on disk.
  void flush();
  /// When what is due next, and the statistics so far, for a run that goes on from here.
  void save(const SaveGroup& group) const;

  /// At the end: last snapshot, state.h5 (the same file as `state`, the fluid's half of the last
  /// checkpoint), table of times, the time line of the last step, and on request the
  /// memory's bandwidth beside the solver's.
  void finish(const std::string& time_line, const std::string& state, bool measure_bandwidth);

 private:
  /// Instants that come every so often; with 0 between them every step is one.
  class Rhythm {
   public:
    Rhythm(double every, double now) : every_(every), next_(now + every) {}
    /// Whether one has come by `now`, give or take half a step.
    bool due(double now, double time_step);
    /// How many come in `steps` more steps, the last of which ends at `end`.
    double count(double end, double time_step, double steps) const;
    void save(const SaveGroup& group) const {
      group.value("every", every_);
      group.value("next", next_);
    }
    /// Takes over the next instant of a run that had the same interval.
    void load(const LoadGroup& group) {
      if (group.value<double>("every") == every_) next_ = group.value<double>("next");
    }

   private:
    double every_, next_;
  };

  /// Slip of the projected velocity over the run, at the rows of history.csv, and forcing loops.
  struct Boundary {
    double largest = 0.0, squares = 0.0, loops_sum = 0.0;
    std::int64_t rows = 0, steps = 0;
    void save(const SaveGroup& group) const;
    void load(const LoadGroup& group);
  };

  void load(const LoadGroup& group);
  /// How large spheres.h5 will become and how far grains go between samples, one sentence; empty
  /// without mobile spheres. `start`: that the spheres are written as they are now, too.
  std::string size_of_samples(bool start) const;
  double slip_rms() const;
  void warn_of_slip() const;
  std::string slip_summary() const;
  std::vector<EffectRow> effects_with_shares(std::span<const TimingRow> times) const;
  HistoryRow history_row() const;
  ProgressState progress_state() const;
  void write_spheres();
  /// Simulation::fixed_loads(), or those of the checkpoint that this run goes on from while it has
  /// made no step; none before the first step of all.
  std::optional<std::vector<SphereLoad>> fixed_loads() const;
  void write_fixed_forces();
  void warn(const std::vector<std::string>& sentences);
  void warn_of_new_spheres();
  void write_history();
  void take_statistics();
  std::vector<PhaseRow> phases() const;

  std::string folder_;
  Simulation<Real>& simulation_;
  const Settings& settings_;
  bool first_rank_;
  std::int64_t first_step_;
  std::optional<std::int64_t> last_step_;
  std::vector<EffectRow> effects_;
  std::size_t phase_;
  Rhythm fields_due_, spheres_due_, fixed_due_;
  std::int64_t fields_step_ = -1, history_step_ = -1;  ///< of the last one written
  std::set<std::string> warned_;   ///< warnings given already, without their numbers
  double worst_residual_ = 0.0;    ///< since the last row of history.csv
  double cfl_made_, cfl_to_come_;  ///< CFL number of the last step and of the next
  std::optional<std::vector<SphereLoad>> fixed_loads_before_;  ///< of the checkpoint's step
  Boundary boundary_;
  FieldWriter fields_;
  std::unique_ptr<Statistics<Real>> statistics_;  ///< where the scene asks for them
  std::size_t statistics_phase_ = 0;
  std::unique_ptr<SphereWriter> spheres_;
  std::unique_ptr<History> history_;    ///< first rank only
  std::unique_ptr<Progress> progress_;  ///< first rank only
};

}  // namespace bedload
