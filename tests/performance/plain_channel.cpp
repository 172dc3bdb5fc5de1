// The flow solver in a bare loop, with nothing around it that knows grains, partners or output:
// what bedload-fluid is measured against where an effect is off. One line of JSON: seconds per step
// of the slowest rank, the steps before WARM_UP left out.
//
//   mpirun -np N plain_channel fluid.toml STEPS WARM_UP [KEY=VALUE]...

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "fluid/channel/channel.hpp"
#include "fluid/channel/runge_kutta.hpp"
#include "fluid/immersed_boundary/sphere_file.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {
namespace {

template <class Real>
double seconds_per_step(const Settings& settings, const std::vector<SphereState>& spheres,
                        int steps, int warm_up) {
  Channel<Real> channel(settings, MPI_COMM_WORLD, spheres);
  double begin = MPI_Wtime();
  for (int n = 0; n < steps; ++n) {
    if (n == warm_up) begin = MPI_Wtime();
    for (int stage = 0; stage < stage_count; ++stage) {
      channel.predict(stage);
      channel.force_spheres(stage);
      channel.project(stage);
    }
    channel.finish_step();
  }
  double seconds = (MPI_Wtime() - begin) / std::max(1, steps - warm_up);
  MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return seconds;
}

void run(std::span<char*> words) {
  if (words.size() < 3) throw UserError("plain_channel fluid.toml STEPS WARM_UP [KEY=VALUE]...");
  const std::vector<std::string> changes(words.begin() + 3, words.end());
  const Settings settings = read_settings(words[0], changes);
  std::vector<SphereState> spheres;
  if (!settings.spheres.file.empty()) {
    const auto file = std::filesystem::path(words[0]).parent_path() / settings.spheres.file;
    spheres = read_spheres(file.string(), make_grid(settings));
  }
  const int steps = std::atoi(words[1]), warm_up = std::atoi(words[2]);
  const auto measure =
      settings.accuracy.precision == "single" ? seconds_per_step<float> : seconds_per_step<double>;
  const double seconds = measure(settings, spheres, steps, warm_up);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) fmt::print("{{\"seconds_per_step\": {:.7f}}}\n", seconds);
}

}  // namespace
}  // namespace bedload

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  try {
    bedload::run({argv + 1, argv + argc});
  } catch (const bedload::UserError& error) {
    std::cerr << error.what() << '\n';
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Finalize();
  return 0;
}
