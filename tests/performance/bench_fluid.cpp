#include <fmt/format.h>
#include <malloc.h>
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "fluid/bandwidth.hpp"
#include "fluid/channel.hpp"
#include "fluid/errors.hpp"
#include "tests/performance/message_counter.hpp"

// How fast the channel solver is, beside the memory bandwidth that the same ranks reach in the same
// run. One line of JSON per row:
//   blocks               how the ranks divide y x z
//   mcells_per_s         million cells times full Runge-Kutta steps (three pressure solves) per
//                        second
//   bytes_per_cell       growth of the peak resident memory of all ranks by the solver, per cell
//   bytes_sent_per_cell  sent between ranks in one step, per cell
//   triad_gb_s           a = b + s c, 24 bytes counted per element, all ranks together
//   roofline_fraction    rate times 480 bytes (240 in single precision) over the triad bandwidth
// Medians over the repeats.

namespace bedload {
namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

int ranks_of(MPI_Comm comm) {
  int ranks = 0;
  MPI_Comm_size(comm, &ranks);
  return ranks;
}

/// Seconds of `work`, from all ranks ready to the last one done.
template <class Work>
double seconds_of(Work&& work) {
  MPI_Barrier(MPI_COMM_WORLD);
  const double begin = MPI_Wtime();
  work();
  MPI_Barrier(MPI_COMM_WORLD);
  return MPI_Wtime() - begin;
}

/// Peak resident memory of this process so far [bytes].
double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return 1024.0 * std::stod(line.substr(6));
  return 0.0;
}

/// Makes the present resident memory the new peak to start from, without what earlier rows have
/// freed.
void forget_peak_memory() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5\n";
}

struct Row {
  std::string blocks, precision;
  double rate, bytes_per_cell, sent_per_cell;
  // Of the fastest sample, ns per own cell and stage.
  std::array<double, flow_phases> phases, phases_of_last;
};

double sum_over_ranks(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return value;
}

/// What the last rank has, on the first.
std::array<double, flow_phases> on_last_rank(std::array<double, flow_phases> phases) {
  MPI_Bcast(phases.data(), flow_phases, MPI_DOUBLE, ranks_of(MPI_COMM_WORLD) - 1, MPI_COMM_WORLD);
  return phases;
}

template <class Real>
Row measure(const std::array<int, 3>& cells, bool implicit, int along_z, double seconds,
            int repeats) {
  Settings s;
  s.grid.cells = cells;
  for (std::size_t d = 0; d < 3; ++d) s.grid.length[d] = double(cells[d]) / cells[1];
  s.fluid.kinematic_viscosity = 1.0 / 4449.0;
  s.flow.driving = Driving::bulk_velocity;
  s.flow.bulk_velocity = 1.0;
  s.start.from = Start::logarithmic;
  s.start.velocity = 1.0;
  s.start.disturbance = 0.2;
  s.time.step = 0.2 / cells[1];
  s.ranks.along_z = along_z;
  s.fluid.diffusion = implicit ? Diffusion::implicit : Diffusion::explicit_;

  forget_peak_memory();
  const double before = peak_memory();
  Channel<Real> channel(s, MPI_COMM_WORLD);
  const auto steps = [&channel](int count) {
    for (int n = 0; n < count; ++n) {
      for (int stage = 0; stage < stage_count; ++stage) channel.advance_stage(stage);
      channel.finish_step();
    }
  };
  steps(2);
  const auto sent_before = traffic().bytes;
  double once = seconds_of([&] { steps(2); }) / 2.0;
  const double sent = sum_over_ranks(static_cast<double>(traffic().bytes - sent_before)) / 2.0;
  MPI_Bcast(&once, 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  const int count = std::max(1, static_cast<int>(seconds / repeats / once));
  std::vector<double> rates;
  std::array<double, flow_phases> phases{};
  const double own_stages = channel.grid().cells[0] * double(channel.decomposition().planes()) *
                            channel.decomposition().rows() * stage_count * count;
  for (int n = 0; n < repeats; ++n) {
    const auto laps = channel.clock().seconds();
    rates.push_back(1e-6 * count * channel.grid().cell_count() / seconds_of([&] { steps(count); }));
    if (rates.back() < *std::max_element(rates.begin(), rates.end())) continue;
    for (std::size_t m = 0; m < flow_phases; ++m)
      phases[m] = 1e9 * (channel.clock().seconds()[m] - laps[m]) / own_stages;
  }
  const double bytes = sum_over_ranks(peak_memory() - before);
  const Decomposition& blocks = channel.decomposition();
  const double count_of_cells = channel.grid().cell_count();
  return {fmt::format("{}x{}", blocks.y_parts(), blocks.z_parts()),
          sizeof(Real) == 4 ? "single" : "double",
          median(rates),
          bytes / count_of_cells,
          sent / count_of_cells,
          phases,
          on_last_rank(phases)};
}

std::array<int, 3> read_grid(const std::string& text) {
  std::array<int, 3> cells{};
  char x = 0, y = 0;
  std::istringstream in(text);
  if (!(in >> cells[0] >> x >> cells[1] >> y >> cells[2]) || x != 'x' || y != 'x')
    throw UserError(fmt::format("--grid is '{}', but must be like 128x128x128.", text));
  return cells;
}

int run(int argc, char** argv) {
  CLI::App app("Rate of the channel solver beside the memory bandwidth, one line of JSON per row");
  std::vector<std::string> grids{"128x128x128", "256x128x128", "160x90x80", "192x192x192"};
  std::vector<std::string> precisions{"double", "single"};
  std::vector<std::string> diffusions{"explicit", "implicit"};
  double seconds = 5.0;
  int repeats = 5, along_z = 0;
  bool with_phases = false;
  std::string commit = "unknown";
  app.add_option("--grid", grids, "Cells, for instance 128x128x128");
  app.add_option("--precision", precisions, "double, single")
      ->check(CLI::IsMember({"double", "single"}));
  app.add_option("--along-z", along_z, "Blocks along z; 0: chosen as in a run");
  app.add_option("--diffusion", diffusions, "explicit, implicit")
      ->check(CLI::IsMember({"explicit", "implicit"}));
  app.add_option("--seconds", seconds, "Time for each row, set-up not counted");
  app.add_option("--repeats", repeats, "Samples that the medians are taken of");
  app.add_flag("--phases", with_phases,
               "Below each row, where the time goes on the first and the last rank");
  app.add_option("--commit", commit, "Name of the measured state, for the rows");
  CLI11_PARSE(app, argc, argv);

  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (const std::string& grid : grids)
    for (const std::string& precision : precisions)
      for (const std::string& diffusion : diffusions) {
        const double triad = triad_bandwidth(MPI_COMM_WORLD, std::max(5, repeats));
        const std::array<int, 3> cells = read_grid(grid);
        const bool single = precision == "single", implicit = diffusion == "implicit";
        const Row row = single ? measure<float>(cells, implicit, along_z, seconds, repeats)
                               : measure<double>(cells, implicit, along_z, seconds, repeats);
        if (rank != 0) continue;
        const double roofline = row.rate * (single ? 240.0 : 480.0) * 1e-3 / triad;
        fmt::print(
            "{{\"name\": \"fluid\", \"grid\": \"{}\", \"ranks\": {}, \"blocks\": \"{}\", "
            "\"precision\": \"{}\", \"diffusion\": \"{}\", \"mcells_per_s\": {:.2f}, "
            "\"bytes_per_cell\": {:.1f}, \"bytes_sent_per_cell\": {:.2f}, \"triad_gb_s\": {:.2f}, "
            "\"roofline_fraction\": {:.3f}, \"commit\": \"{}\"}}\n",
            grid, ranks_of(MPI_COMM_WORLD), row.blocks, row.precision, diffusion, row.rate,
            row.bytes_per_cell, row.sent_per_cell, triad, roofline, commit);
        if (with_phases)
          for (std::size_t n = 0; n < flow_phases; ++n)
            fmt::print("  {:24} {:6.2f} {:6.2f} ns per cell and stage\n", flow_phase_names[n],
                       row.phases[n], row.phases_of_last[n]);
        std::cout.flush();
      }
  return 0;
}

}  // namespace
}  // namespace bedload

int main(int argc, char** argv) {
  mallopt(M_MMAP_THRESHOLD,
          1 << 17);  // fields go back to the system, so that each row shows its own
  MPI_Init(&argc, &argv);
  int result = 1;
  try {
    result = bedload::run(argc, argv);
  } catch (const bedload::UserError& error) {
    std::cerr << error.what() << '\n';
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Finalize();
  return result;
}
