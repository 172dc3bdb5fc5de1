#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "fluid/channel/phase_clock.hpp"

namespace bedload {

/// One phase of the channel solver over a whole run.
struct PhaseRow {
  std::string phase;
  double seconds = 0.0;         ///< mean over ranks
  double ns_per_cell = 0.0;     ///< all ranks together, per cell and stage
  double bytes_per_cell = 0.0;  ///< moved between memory and processor, per cell and stage
  double gb_per_s = 0.0;        ///< of it, all ranks together
};

/// What the solver was asked to do while the clocks ran.
struct PhaseWork {
  double cells = 0.0, stages = 0.0;  ///< of the whole grid; all stages of all steps
  std::size_t real_bytes = 8;
  bool old_pressure = false;
  bool implicit_diffusion = false;  ///< its traffic is not counted: times alone
};

/// Collective over `comm`.
std::vector<PhaseRow> phase_rows(const PhaseClock& clock, const PhaseWork& work, MPI_Comm comm);

/// The rows as a table for the terminal, beside the bandwidth [GB/s] that the same ranks reach; 0:
/// it was not measured.
std::string phase_table(const std::vector<PhaseRow>& rows, double bandwidth);

/// folder/phases.csv: phase,seconds,ns_per_cell,bytes_per_cell,gb_per_s,bandwidth_gb_per_s. First
/// rank.
void write_phases(const std::string& folder, const std::vector<PhaseRow>& rows, double bandwidth);

}  // namespace bedload
