#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coupling/bedload_fluid/run_output.hpp"
#include "coupling/bedload_fluid/simulation.hpp"
#include "coupling/exchange/fluid_side.hpp"
#include "fluid/checkpoint/checkpoint_store.hpp"
#include "fluid/checkpoint/state_file.hpp"

namespace bedload {

/// Group of the fluid's half that RunOutput saves and loads.
inline constexpr const char* output_group = "output";

/// A checkpoint that a run goes on from.
struct Resumption {
  CheckpointPlace place;
  StateHeader header;
  /// The fluid's half, open until the run has begun.
  std::shared_ptr<const StateReader> state;

  LoadGroup run() const { return state->run(); }

  /// The division of the box, when the run has as many ranks as the one before and the scene does
  /// not ask for another; else empty.
  Cuts cuts(int ranks, const Settings& settings) const;
  double time_step() const;
  /// The command line's "key=value" of the run before, and behind them, in the place of those of
  /// the same key, `now`.
  std::vector<std::string> overrides(const std::vector<std::string>& now) const;
};

/// What the settings of this run have otherwise than those of the run before, and which values of
/// its command line hold on; a sentence each.
std::vector<std::string> differences(const Resumption& from, const Settings& settings,
                                     const std::vector<std::string>& now);

/// Throws UserError when the fixed spheres of a run without LIGGGHTS are others than before.
void check_fixed_spheres(const Resumption& from, std::span<const SphereState> spheres);

/// Finds what `--restart where` names and checks both halves. Throws UserError with what is wrong
/// and what to do: another checkpoint that is whole, else a new run. Collective.
Resumption open_checkpoint(const std::string& where, bool with_grains, MPI_Comm comm);

/// Throws UserError when the scene has another box or grid than the run before.
void check_scene(const Resumption& from, const Settings& settings);

/// Lets FFTW choose the algorithms of the run before, which a fresh measurement might not.
void learn_transforms(const Resumption& from);

/// Sets the flow to what the checkpoint holds.
template <class Real>
void restore_flow(const Resumption& from, Channel<Real>& channel);

/// Writes checkpoints when time, clock or a signal ask for one. Collective over the fluid's ranks.
template <class Real>
class Checkpoints {
 public:
  /// `from`: the one that the run goes on from. Those of `out` behind the step `kept_until` are
  /// removed; -1: all.
  Checkpoints(const std::string& out, Simulation<Real>& simulation, RunOutput<Real>& output,
              FluidSide* partner, const Resumption* from, std::int64_t kept_until);

  /// After each step: writes what is due. Returns why the run has to end before its time, nothing
  /// when it goes on.
  std::optional<std::string> after_step();

  /// Writes one now.
  void write();

  /// The last one that is whole; step -1: there is none.
  const CheckpointPlace& last() const { return last_; }

 private:
  enum class Due : int { nothing, checkpoint, end_by_limit, end_by_signal };
  Due find_due(int& signal);
  void save(const SaveGroup& group) const;

  std::string out_;
  Simulation<Real>& simulation_;
  RunOutput<Real>& output_;
  FluidSide* partner_;
  const Settings& settings_;
  std::size_t phase_;
  double began_, written_;  ///< by the clock [s]
  double next_time_;        ///< [T]
  CheckpointPlace last_;
};

}  // namespace bedload
