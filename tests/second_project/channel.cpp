// The flow solver as a library: a laminar channel between two walls, driven by a constant pressure
// gradient, from its own parabola; prints how far the bulk velocity is from the exact one.
#include "fluid/channel/channel.hpp"

#include <mpi.h>

#include <cmath>
#include <cstdio>

#include "fluid/settings/settings.hpp"

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  {
    const bedload::Settings settings = bedload::parse_settings(R"(
      [grid]
      cells = [8, 32, 8]
      length = [0.5, 2.0, 0.5]
      [boundary]
      y = "no_slip"
      [fluid]
      kinematic_viscosity = 0.1
      [flow]
      driving = "pressure_gradient"
      pressure_gradient = 0.3
      [start]
      from = "laminar"
      velocity = 1.0
      [time]
      step = 0.002
      end = 1.0
    )",
                                                               "channel.cpp");
    bedload::Channel<double> channel(settings, MPI_COMM_WORLD);
    while (channel.time() < settings.time.end - 1e-9) {
      for (int stage = 0; stage < bedload::stage_count; ++stage) {
        channel.predict(stage);
        channel.project(stage);
      }
      channel.finish_step();
    }
    // u_b = G H^2 / (12 nu) for walls H apart
    const double height = settings.grid.length[1];
    const double exact = settings.flow.pressure_gradient * height * height /
                         (12 * settings.fluid.kinematic_viscosity);
    const double bulk = channel.bulk_velocity();
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank == 0)
      std::printf("steps %lld bulk %.6f exact %.6f\n", static_cast<long long>(channel.step()), bulk,
                  exact);
  }
  MPI_Finalize();
}
