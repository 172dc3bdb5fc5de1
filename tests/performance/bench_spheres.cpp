#include <fmt/format.h>
#include <mpi.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"

// What the markers cost on one core: processor time per marker of each part of a stage, on the bed
// of `bedload bench bed`, repeated along x. One line of JSON per row:
//   fixed_ns, mobile_ns   one loop of slip and spreading, per marker (three components)
//   place_ns              placing and weighing the mobile spheres' markers, per marker of these
//   interior_ns           momentum inside, before and after, per marker of the mobile spheres
//   mobile_to_fixed       a mobile marker's cost in the whole of a step over a fixed one's:
//                         (mobile_ns + place_ns + interior_ns)/fixed_ns
//   stage_ms              all of a stage, fixed and mobile, one loop
// Medians over the repeats.

namespace bedload {
namespace {

double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class Work>
double seconds_of(int repeats, Work work) {
  std::vector<double> times;
  for (int n = 0; n < repeats; ++n) {
    const double begin = processor_seconds();
    work();
    times.push_back(processor_seconds() - begin);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

/// Seconds of a stage, the mean of a step's three stages; use(is the first).
template <class Use>
double mean_of_stages(int repeats, Use use) {
  return (seconds_of(repeats, [&] { use(true); }) +
          2.0 * seconds_of(repeats, [&] { use(false); })) /
         3.0;
}

/// The bed, `copies` times one behind the other along x.
std::vector<SphereState> bed(int copies, bool mobile) {
  std::vector<SphereState> spheres;
  for (int n = 0; n < 144 * copies; ++n) {
    const int i = n / 8, j = n % 8;
    const double x = (i + 0.5) * 16.0 / 18.0, z = j + 0.25 + 0.5 * (i % 2);
    spheres.push_back({.tag = 2 * n,
                       .position = {x, 0.5, std::fmod(z, 8.0)},
                       .velocity = Vec3::Zero(),
                       .angular_velocity = Vec3::Zero(),
                       .radius = 0.5,
                       .mobile = false});
    if (!mobile || n % 144 % 3 != 0 || n % 144 >= 138) continue;
    SphereState grain = spheres.back();
    grain.tag = 2 * n + 1;
    grain.position = {x + 0.303819, 1.330979, std::fmod(z + 0.5, 8.0)};
    grain.mobile = true;
    spheres.push_back(grain);
  }
  return spheres;
}

template <class Real>
void measure(const std::string& precision, int copies, int repeats) {
  Settings s;
  s.grid.cells = {160 * copies, 90, 80};
  s.grid.length = {16.0 * copies, 9.0, 8.0};
  s.spheres.forcing_loops = 1;
  const Grid grid = make_grid(s);
  const Decomposition decomposition(grid, MPI_COMM_WORLD);
  Field<Real> velocity(grid, decomposition.extent(), 3);
  for (int j = 0; j < decomposition.planes(); ++j)
    for (int k = 0; k < decomposition.rows(); ++k)
      for (int i = 0; i < grid.cells[0]; ++i)
        velocity.row(j, k)[i] = Real(0.1) * static_cast<Real>(std::sin(0.3 * i + 0.2 * j + k));
  const auto cost = [&](bool with_mobile, auto use) {
    ImmersedBoundary<Real> boundary(s, grid, decomposition);
    const std::vector<SphereState> all = bed(copies, with_mobile);
    std::vector<SphereState> mobile;
    for (const SphereState& sphere : all)
      if (sphere.mobile) mobile.push_back(sphere);
    boundary.set_spheres(all);
    use(boundary, mobile);
  };
  const int each = marker_count(5.0, s.spheres.marker_density);
  const double fixed = 144.0 * copies * each, moving = 46.0 * copies * each;
  double fixed_loop = 0.0, all_loops = 0.0, place = 0.0, interior = 0.0;
  cost(false, [&](auto& boundary, auto&) {
    fixed_loop = seconds_of(repeats, [&] { boundary.force(velocity, 0.01, 0.01); });
  });
  cost(true, [&](auto& boundary, auto& mobile) {
    // A step's first stage weighs markers and carries layers, the others do not.
    place = mean_of_stages(repeats, [&](bool first) {
      for (SphereState& sphere : mobile) sphere.position.x() += 1e-6;  // those at rest keep markers
      boundary.move_spheres(mobile, s.time.step, first);
    });
    boundary.move_spheres(mobile, s.time.step);
    const double before = seconds_of(repeats, [&] { boundary.start_stage(velocity); });
    all_loops = mean_of_stages(repeats,
                               [&](bool first) {
                                 boundary.start_stage(velocity);
                                 boundary.force(velocity, 0.01, first ? 0.01 : 0.0);
                               }) -
                2 * before;
    interior = 2 * before;
  });
  const auto per_marker = [](double seconds, double markers) { return 1e9 * seconds / markers; };
  const double fixed_ns = per_marker(fixed_loop, fixed),
               mobile_ns = per_marker(all_loops - fixed_loop, moving),
               place_ns = per_marker(place, moving), interior_ns = per_marker(interior, moving);
  fmt::print(
      "{{\"name\": \"spheres\", \"precision\": \"{}\", \"markers_fixed\": {}, \"markers_mobile\": "
      "{}, \"fixed_ns\": {:.1f}, \"mobile_ns\": {:.1f}, \"place_ns\": {:.1f}, \"interior_ns\": "
      "{:.1f}, \"mobile_to_fixed\": {:.2f}, \"stage_ms\": {:.3f}}}\n",
      precision, fixed, moving, fixed_ns, mobile_ns, place_ns, interior_ns,
      (mobile_ns + place_ns + interior_ns) / fixed_ns, 1e3 * (all_loops + place + interior));
}

}  // namespace
}  // namespace bedload

int main(int argc, char** argv) {
  using namespace bedload;
  CLI::App app("Processor time of the spheres' markers, one line of JSON per row");
  int repeats = 15;
  std::vector<int> copies{1, 3};
  std::vector<std::string> precisions{"double", "single"};
  app.add_option("--repeats", repeats, "Samples that the medians are taken of");
  app.add_option("--copies", copies, "Lengths of the bed");
  app.add_option("--precision", precisions, "double, single");
  CLI11_PARSE(app, argc, argv);
  MPI_Init(&argc, &argv);
  for (const int n : copies)
    for (const std::string& precision : precisions)
      (precision == "single" ? measure<float> : measure<double>)(precision, n, repeats);
  MPI_Finalize();
}
