#pragma once

#include <mpi.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "coupling/fluid_side.hpp"
#include "coupling/run_output.hpp"
#include "coupling/simulation.hpp"
#include "fluid/output/checkpoint_store.hpp"
#include "fluid/output/state_file.hpp"

namespace bedload {

/// A checkpoint that a run goes on from: where it is, and what is needed of it before the solver
/// is made.
struct Resumption {
  CheckpointPlace place;
  StateHeader header;
  StateExtras extras;

  /// The division of the box, when the run has as many ranks as the one before and the scene does
  /// not ask for another; else empty.
  Cuts cuts(int ranks, const Settings& settings) const;
  double time_step() const;
};

/// Finds what `--restart where` names and checks both halves. Throws UserError with one sentence
/// that, when there is one, names an earlier checkpoint that is whole. Collective.
Resumption open_checkpoint(const std::string& where, bool with_grains, MPI_Comm comm);

/// Throws UserError when the scene has another box or grid than the run before.
void check_scene(const Resumption& from, const Settings& settings);

/// Lets FFTW choose the algorithms of the run before, which a fresh measurement might not.
template <class Real>
void learn_transforms(const Resumption& from);

/// Sets the flow to what the checkpoint holds.
template <class Real>
void restore_flow(const Resumption& from, Channel<Real>& channel);

/// Writes checkpoints when time, clock or a signal ask for one. Collective over the fluid's ranks.
template <class Real>
class Checkpoints {
 public:
  /// `from`: the one that the run goes on from.
  Checkpoints(const std::string& out, Simulation<Real>& simulation, RunOutput<Real>& output,
              FluidSide* partner, const Resumption* from);

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
  StateExtras extras() const;

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
