#include "fluid/output/phase_table.hpp"

#include <fmt/format.h>

#include "fluid/files/atomic_file.hpp"

namespace bedload {

std::vector<PhaseRow> phase_rows(const PhaseClock& clock, const PhaseWork& work, MPI_Comm comm) {
  std::array<double, flow_phases> seconds = clock.seconds();
  MPI_Allreduce(MPI_IN_PLACE, seconds.data(), static_cast<int>(flow_phases), MPI_DOUBLE, MPI_SUM,
                comm);
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  std::vector<PhaseRow> rows;
  for (std::size_t n = 0; n < flow_phases; ++n) {
    PhaseRow row;
    row.phase = flow_phase_names[n];
    row.seconds = seconds[n] / ranks;
    if (!work.implicit_diffusion)
      row.bytes_per_cell = static_cast<double>(work.real_bytes) *
                           numbers_moved(static_cast<FlowPhase>(n), work.old_pressure);
    const double updates = work.cells * work.stages;
    if (updates > 0.0) row.ns_per_cell = 1e9 * row.seconds / updates;
    if (row.seconds > 0.0) row.gb_per_s = 1e-9 * row.bytes_per_cell * updates / row.seconds;
    rows.push_back(row);
  }
  return rows;
}

std::string phase_table(const std::vector<PhaseRow>& rows, double bandwidth) {
  const bool measured = bandwidth > 0.0;
  std::string text =
      fmt::format("{:<22}  {:>9}  {:>8}  {:>7}  {:>7}{}\n", "phase of the flow", "seconds",
                  "ns/cell", "B/cell", "GB/s", measured ? "  of bandwidth" : "");
  for (const PhaseRow& row : rows) {
    text += fmt::format("{:<22}  {:>9.3f}  {:>8.2f}", row.phase, row.seconds, row.ns_per_cell);
    if (row.bytes_per_cell > 0.0)
      text += fmt::format("  {:>7.0f}  {:>7.1f}", row.bytes_per_cell, row.gb_per_s);
    if (row.bytes_per_cell > 0.0 && measured)
      text += fmt::format("  {:>11.0f}%", 100.0 * row.gb_per_s / bandwidth);
    text += "\n";
  }
  text += "per cell and Runge-Kutta stage, all ranks together";
  if (measured)
    text +=
        fmt::format("; memory bandwidth of these ranks {:.1f} GB/s (triad, just now)", bandwidth);
  return text + "\n";
}

void write_phases(const std::string& folder, const std::vector<PhaseRow>& rows, double bandwidth) {
  std::string text = "phase,seconds,ns_per_cell,bytes_per_cell,gb_per_s,bandwidth_gb_per_s\n";
  for (const PhaseRow& row : rows)
    text += fmt::format("\"{}\",{:.6f},{:.4f},{:.2f},{:.3f},{:.3f}\n", row.phase, row.seconds,
                        row.ns_per_cell, row.bytes_per_cell, row.gb_per_s, bandwidth);
  write_text_file(folder + "/phases.csv", text);
}

}  // namespace bedload
