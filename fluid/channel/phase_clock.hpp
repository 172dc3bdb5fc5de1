#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>

namespace bedload {

/// What the channel solver does in a stage, in this order.
enum class FlowPhase : std::size_t {
  momentum,      ///< explicit predictor
  divergence,    ///< of u*, into the scratch plane of the transform; mostly taken with momentum
                 ///< where nothing stands between the two
  elimination,   ///< plane transform and elimination upwards
  coupling,      ///< between the ranks: reduced system, bulk velocity
  substitution,  ///< back-substitution downwards and transform back
  correction,    ///< gradient, shift of the bulk velocity, pressure
  halo,          ///< ghost layers from the neighbours
};
inline constexpr std::size_t flow_phases = 7;
inline constexpr std::array<const char*, flow_phases> flow_phase_names{
    "momentum",   "divergence", "transform, elimination", "coupling of the ranks", "substitution",
    "correction", "halo"};

/// Wall clock by phase. One reading of the clock ends a phase and begins the next, so that it can
/// be read plane by plane.
class PhaseClock {
 public:
  void start() { last_ = MPI_Wtime(); }
  void lap(FlowPhase phase) {
    const double now = MPI_Wtime();
    seconds_[static_cast<std::size_t>(phase)] += now - last_;
    last_ = now;
  }
  const std::array<double, flow_phases>& seconds() const { return seconds_; }

 private:
  double last_ = 0.0;
  std::array<double, flow_phases> seconds_{};
};

/// Numbers of the fields that a phase moves between memory and processor, per cell and stage, mean
/// over the three stages. Lines that the sweep has just used count as being in the cache; a write
/// counts once. `old_pressure`: the predictor takes the old pressure's gradient, and where spheres
/// are it stands apart from the divergence, which then reads u* again (not counted: it is a matter
/// of some planes).
///
///   momentum      reads u, v, w, writes them (6); the tendency is written, both, read (12/3 = 4)
///   elimination   writes the right-hand side; the coefficients that planes share stay in the cache
///   substitution  reads it again
///   correction    reads and writes u, v, w (6); writes p in the last stage (1/3), with the old
///                 pressure reads and writes it in each (2)
constexpr double numbers_moved(FlowPhase phase, bool old_pressure) {
  switch (phase) {
    case FlowPhase::momentum:
      return 10.0 + (old_pressure ? 1.0 : 0.0);
    case FlowPhase::elimination:
    case FlowPhase::substitution:
      return 1.0;
    case FlowPhase::correction:
      return 6.0 + (old_pressure ? 2.0 : 1.0 / 3.0);
    case FlowPhase::divergence:
    case FlowPhase::coupling:
    case FlowPhase::halo:
      break;
  }
  return 0.0;
}

}  // namespace bedload
