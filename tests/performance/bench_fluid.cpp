#include <fmt/format.h>
#include <malloc.h>
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "fluid/channel/channel.hpp"
#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/output/bandwidth.hpp"
#include "fluid/poisson/fftw.hpp"
#include "fluid/settings/errors.hpp"
#include "tests/performance/message_counter.hpp"

// How fast the channel solver is, beside the memory bandwidth that the same ranks reach in the same
// run. One line of JSON per row; a sample is one pass of the triad and some steps of the solver:
//   blocks               how the ranks divide y x z
//   y                    cubes or stretched
//   spheres              none, or bed: a layer of fixed spheres on the floor, ten cells in diameter
//   mcells_per_s         million cells times full Runge-Kutta steps (three pressure solves) per
//                        second, median of the samples
//   mcells_per_s_range   the slowest and the fastest sample
//   fluid_ns             time of all ranks in the phases of the solver, spheres not among them, per
//                        cell and step [ns]: median of the samples
//   bytes_per_cell       growth of the peak resident memory of all ranks by the solver, per cell
//   bytes_sent_per_cell  sent between ranks in one step, per cell
//   triad_gb_s           a = b + s c on the same ranks and kind of pages, 24 bytes counted per
//                        element, all ranks together: median of the samples
//   triad_gb_s_range     the slowest and the fastest
//   roofline_fraction    480 bytes (240 in single precision) times the rate over the triad of the
//                        same sample: median

namespace bedload {
namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
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
  std::string decomposition, precision;
  double bytes_per_cell, sent_per_cell;
  std::vector<double> rates, triads, fluid_ns;  // by sample
  // Medians of the same samples, ns per own cell and stage.
  std::array<double, flow_phases> phases, phases_of_last;
};

/// What a row measures.
struct Case {
  std::array<int, 3> cells;
  bool stretched, implicit, bed;
  int along_z;
};

double sum_over_ranks(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return value;
}

/// What the last rank has, on the first.
std::array<double, flow_phases> on_last_rank(std::array<double, flow_phases> phases) {
  MPI_Bcast(phases.data(), flow_phases, MPI_DOUBLE, size_of(MPI_COMM_WORLD) - 1, MPI_COMM_WORLD);
  return phases;
}

/// A layer of fixed spheres on the floor, in squares, ten cells in diameter.
std::vector<SphereState> bed(const Grid& grid) {
  constexpr int diameter = 10;
  const int columns = grid.cells[0] / diameter, rows = grid.cells[2] / diameter;
  std::vector<SphereState> spheres;
  for (int n = 0; n < columns * rows; ++n) {
    SphereState& sphere = spheres.emplace_back();
    sphere.tag = n;
    sphere.position = {(n % columns + 0.5) * grid.length[0] / columns, 0.5 * diameter * grid.h,
                       (n / columns + 0.5) * grid.length[2] / rows};
    sphere.radius = 0.5 * diameter * grid.h;
    sphere.mobile = false;
  }
  return spheres;
}

template <class Real>
Row measure(const Case& what, Triad& triad, double seconds, int repeats) {
  Fftw<Real>::forget();  // what it has learned for other rows
  const auto& cells = what.cells;
  Settings s;
  s.grid.cells = cells;
  if (what.stretched) s.grid.y_stretching = 1.5;
  for (std::size_t d = 0; d < 3; ++d) s.grid.length[d] = double(cells[d]) / cells[1];
  s.fluid.kinematic_viscosity = 1.0 / 4449.0;
  s.flow.driving = Driving::bulk_velocity;
  s.flow.bulk_velocity = 1.0;
  s.start.from = Start::logarithmic;
  s.start.velocity = 1.0;
  s.start.disturbance = 0.2;
  s.time.step = 0.2 / cells[1];
  s.ranks.along_z = what.along_z;
  s.fluid.diffusion = what.implicit ? Diffusion::implicit : Diffusion::explicit_;

  forget_peak_memory();
  const double before = peak_memory();
  const auto spheres = what.bed ? bed(make_grid(s)) : std::vector<SphereState>{};
  Channel<Real> channel(s, MPI_COMM_WORLD, spheres);
  const auto steps = [&channel](int count) {
    for (int n = 0; n < count; ++n) {
      for (int stage = 0; stage < stage_count; ++stage) {
        channel.predict(stage);
        channel.force_spheres(stage);
        channel.project(stage);
      }
      channel.finish_step();
    }
  };
  steps(2);
  const auto sent_before = traffic().bytes;
  double once = seconds_of([&] { steps(2); }) / 2.0;
  const double sent = sum_over_ranks(static_cast<double>(traffic().bytes - sent_before)) / 2.0;
  MPI_Bcast(&once, 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  const int count = std::max(1, static_cast<int>(seconds / repeats / once));
  std::vector<double> rates, triads, fluid_ns;
  std::array<std::vector<double>, flow_phases> laps;
  const double own_stages = channel.grid().cells[0] * double(channel.decomposition().planes()) *
                            channel.decomposition().rows() * stage_count * count;
  for (int n = 0; n < repeats; ++n) {
    triads.push_back(triad.pass());
    const auto before_steps = channel.clock().seconds();
    rates.push_back(1e-6 * count * channel.grid().cell_count() / seconds_of([&] { steps(count); }));
    double own_seconds = 0.0;
    for (std::size_t m = 0; m < flow_phases; ++m) {
      const double lap = channel.clock().seconds()[m] - before_steps[m];
      laps[m].push_back(1e9 * lap / own_stages);
      own_seconds += lap;
    }
    fluid_ns.push_back(1e9 * sum_over_ranks(own_seconds) / (channel.grid().cell_count() * count));
  }
  std::array<double, flow_phases> phases{};
  std::transform(laps.begin(), laps.end(), phases.begin(), median);
  const double bytes = sum_over_ranks(peak_memory() - before);
  const Decomposition& decomposition = channel.decomposition();
  const double count_of_cells = channel.grid().cell_count();
  return {fmt::format("{}x{}", decomposition.y_parts(), decomposition.z_parts()),
          sizeof(Real) == 4 ? "single" : "double",
          bytes / count_of_cells,
          sent / count_of_cells,
          rates,
          triads,
          fluid_ns,
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

/// What a row measures, in the words of the options.
struct Words {
  std::string grid, y = "cubes", spheres = "none", diffusion = "explicit";
};

/// Cubes of several sizes, planes that outgrow the caches, stretched y, implicit diffusion,
/// spheres.
std::vector<Words> usual_rows() {
  std::vector<Words> rows;
  for (const char* grid : {"128x128x128", "96x96x96", "256x128x128", "160x90x80", "192x192x192",
                           "320x320x320", "260x100x130", "1040x200x135"})
    rows.push_back({grid});
  rows.push_back({.grid = "128x128x128", .y = "stretched"});
  for (const char* grid : {"128x128x128", "192x192x192", "160x90x80"})
    rows.push_back({.grid = grid, .diffusion = "implicit"});
  for (const char* grid : {"128x128x128", "160x90x80", "260x100x130"})
    rows.push_back({.grid = grid, .spheres = "bed"});
  return rows;
}

void print_row(const Words& words, const Row& row, bool with_phases, const std::string& commit) {
  const bool single = row.precision == "single";
  std::vector<double> fractions;
  for (std::size_t n = 0; n < row.rates.size(); ++n)
    fractions.push_back(row.rates[n] * (single ? 0.24 : 0.48) / row.triads[n]);
  const auto [slowest, fastest] = std::minmax_element(row.rates.begin(), row.rates.end());
  const auto [least, most] = std::minmax_element(row.triads.begin(), row.triads.end());
  fmt::print(
      R"({{"name": "fluid", "grid": "{}", "y": "{}", "spheres": "{}", "ranks": {}, "blocks": "{}", )"
      R"("precision": "{}", "diffusion": "{}", "mcells_per_s": {:.2f}, )"
      R"("mcells_per_s_range": [{:.2f}, {:.2f}], "fluid_ns": {:.2f}, "bytes_per_cell": {:.1f}, )"
      R"("bytes_sent_per_cell": {:.2f}, "triad_gb_s": {:.2f}, "triad_gb_s_range": [{:.2f}, {:.2f}], )"
      R"("roofline_fraction": {:.3f}, "commit": "{}"}})"
      "\n",
      words.grid, words.y, words.spheres, size_of(MPI_COMM_WORLD), row.decomposition, row.precision,
      words.diffusion, median(row.rates), *slowest, *fastest, median(row.fluid_ns),
      row.bytes_per_cell, row.sent_per_cell, median(row.triads), *least, *most, median(fractions),
      commit);
  if (with_phases)
    for (std::size_t n = 0; n < flow_phases; ++n)
      fmt::print("  {:24} {:6.2f} {:6.2f} ns per cell and stage\n", flow_phase_names[n],
                 row.phases[n], row.phases_of_last[n]);
  std::cout.flush();
}

int run(int argc, char** argv) {
  CLI::App app("Rate of the channel solver beside the memory bandwidth, one line of JSON per row");
  std::vector<std::string> grids{"128x128x128"}, ys{"cubes"}, beds{"none"}, diffusions{"explicit"};
  std::vector<std::string> precisions{"double", "single"};
  double seconds = 2.0;
  int repeats = 5, along_z = 0;
  bool with_phases = false;
  std::string commit = "unknown";
  const std::vector<CLI::Option*> chosen{
      app.add_option("--grid", grids,
                     "Cells, for instance 128x128x128 (none of these four: 15 rows)"),
      app.add_option("--y", ys, "cubes, stretched")->check(CLI::IsMember({"cubes", "stretched"})),
      app.add_option("--spheres", beds, "none, bed")->check(CLI::IsMember({"none", "bed"})),
      app.add_option("--diffusion", diffusions, "explicit, implicit")
          ->check(CLI::IsMember({"explicit", "implicit"}))};
  app.add_option("--precision", precisions, "double, single")
      ->check(CLI::IsMember({"double", "single"}));
  app.add_option("--along-z", along_z, "Blocks along z; 0: chosen as in a run");
  app.add_option("--seconds", seconds, "Time for each row, set-up not counted");
  app.add_option("--repeats", repeats, "Samples that the medians are taken of");
  app.add_flag("--phases", with_phases,
               "Below each row, where the time goes on the first and the last rank");
  app.add_option("--commit", commit, "Name of the measured state, for the rows");
  CLI11_PARSE(app, argc, argv);

  std::vector<Words> rows;
  for (const std::string& grid : grids)
    for (const std::string& y : ys)
      for (const std::string& spheres : beds)
        for (const std::string& diffusion : diffusions)
          rows.push_back({grid, y, spheres, diffusion});
  if (std::all_of(chosen.begin(), chosen.end(), [](const CLI::Option* o) { return o->empty(); }))
    rows = usual_rows();
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  Triad triad(MPI_COMM_WORLD);
  for (const Words& words : rows)
    for (const std::string& precision : precisions) {
      const Case what{read_grid(words.grid), words.y == "stretched", words.diffusion == "implicit",
                      words.spheres == "bed", along_z};
      const Row row =
          (precision == "single" ? measure<float> : measure<double>)(what, triad, seconds, repeats);
      if (rank == 0) print_row(words, row, with_phases, commit);
    }
  return 0;
}

}  // namespace
}  // namespace bedload

int main(int argc, char** argv) {
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
