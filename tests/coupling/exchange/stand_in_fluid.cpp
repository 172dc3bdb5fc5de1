// A fluid without a flow: takes the place of bedload-fluid in tests of the exchange. It makes up
// the loads by a law that can be summed by hand, follows each sphere along the parabolas that these
// loads give, and compares with what LIGGGHTS sends back.

#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <thread>

#include "coupling/exchange/fluid_side.hpp"
#include "coupling/exchange/stages.hpp"
#include "coupling/job/roles.hpp"
#include "fluid/grid/block_map.hpp"
#include "fluid/immersed_boundary/gather.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

struct Options {
  std::vector<double> length{4.0, 2.0, 2.0};
  std::vector<int> periodic{1, 0, 1};
  std::vector<double> gravity{0.0, -0.5, 0.0};
  double time_step = 0.01, cell_size = 0.025, sphere_density = 2000.0;
  std::int64_t steps = 100;
  double pressure_seconds = 0.0;  // how long a "pressure solve" takes, per stage
  double alternate = 1.0;         // every second step is this much longer
  std::int64_t mistake_at = -1;   // a user's mistake found in this step
  std::int64_t die_at = -1;       // kill -9 in this step
  int z_parts = 1;                // the fluid's ranks divide z into this many parts, and y
  std::string out;
};

FluidSceneInfo scene_info_of(const Options& o) {
  FluidSceneInfo scene_info{};
  for (std::size_t d = 0; d < 3; ++d) {
    scene_info.length[d] = o.length[d];
    scene_info.periodic[d] = o.periodic[d];
    scene_info.gravity[d] = o.gravity[d];
  }
  scene_info.dem_steps = DemSteps{}.in_stage;
  scene_info.density = 1000.0;
  scene_info.kinematic_viscosity = 1e-3;
  scene_info.time_step = o.time_step;
  scene_info.cell_size = o.cell_size;
  return scene_info;
}

/// Differs from sphere to sphere, from stage to stage, and with the motion: a linear drag, a push
/// that grows with the tag, and a torque.
SphereLoad load_on(const SphereState& s, std::int64_t step, int stage) {
  const double phase = 0.1 * static_cast<double>(3 * step + stage);
  const double tag = static_cast<double>(s.tag);
  SphereLoad load;
  load.tag = s.tag;
  load.force = -5.0 * s.velocity + Vec3(tag * std::cos(phase), 14.0, -tag * std::sin(phase));
  load.torque = -0.1 * s.angular_velocity + 0.01 * Vec3(std::sin(phase), tag, std::cos(phase));
  return load;
}

/// A constant force over `time` moves a sphere along a parabola:
///   x += v t + a t^2/2,   v += a t,   omega += T t / I
SphereState flown(SphereState s, const SphereLoad& load, double time, const Options& o) {
  const double mass = o.sphere_density * 4.0 / 3.0 * std::numbers::pi * std::pow(s.radius, 3);
  const Vec3 acceleration = load.force / mass + Vec3(o.gravity[0], o.gravity[1], o.gravity[2]);
  s.position += time * s.velocity + 0.5 * time * time * acceleration;
  s.velocity += time * acceleration;
  s.angular_velocity += time * load.torque / (0.4 * mass * s.radius * s.radius);
  return s;
}

std::string row(const Vec3& v) { return fmt::format("{},{},{}", v[0], v[1], v[2]); }

/// Largest difference of two states, positions taken through the periodic faces.
double difference(const SphereState& a, const SphereState& b, const Options& o) {
  Vec3 apart = a.position - b.position;
  for (int d = 0; d < 3; ++d) {
    const auto u = static_cast<std::size_t>(d);
    if (o.periodic[u] != 0) apart[d] = std::remainder(apart[d], o.length[u]);
  }
  return std::max({apart.lpNorm<Eigen::Infinity>(),
                   (a.velocity - b.velocity).lpNorm<Eigen::Infinity>(),
                   (a.angular_velocity - b.angular_velocity).lpNorm<Eigen::Infinity>()});
}

void check_inside(const SphereState& s, const Options& o) {
  for (int d = 0; d < 3; ++d) {
    const auto u = static_cast<std::size_t>(d);
    if (s.position[d] < 0.0 || s.position[d] >= o.length[u])
      throw UserError(fmt::format("sphere {} came at {} outside the box.", s.tag, s.position[d]));
  }
}

std::vector<int> even_parts(int cells, int parts) {
  std::vector<int> first;
  for (int n = 0; n <= parts; ++n) first.push_back(n * cells / parts);
  return first;
}

BlockMap blocks_of(const Options& o, int ranks) {
  BlockMap blocks;
  for (std::size_t d = 0; d < 3; ++d) {
    blocks.length[d] = o.length[d];
    blocks.periodic[d] = o.periodic[d] != 0;
  }
  blocks.h = o.cell_size;
  const auto cells = [&](std::size_t d) {
    return static_cast<int>(std::lround(o.length[d] / o.cell_size));
  };
  blocks.y = even_parts(cells(1), ranks / o.z_parts);
  blocks.z = even_parts(cells(2), o.z_parts);
  return blocks;
}

bool same_tags(const std::vector<SphereState>& a, const std::vector<SphereState>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& s, const auto& t) { return s.tag == t.tag; });
}

double cpu_seconds() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return static_cast<double>(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
}

void run(Job& job, const Options& o) {
  FluidSide side(job);
  side.introduce(scene_info_of(o));
  const PartnerScene dem = side.meet();

  if (job.rank() == 0)
    fmt::print("spheres fixed={} mobile={}\n", dem.scene_info.fixed, dem.scene_info.mobile);

  const BlockMap blocks = blocks_of(o, job.size());
  const auto is_home = [&](const SphereState& s) { return blocks.home(s.position) == job.rank(); };
  double way_time = 1e9;  // of a sphere through a stage, a cell at most
  const auto is_near = [&](const SphereState& s) {
    const double ahead = std::min(blocks.h, way_time * s.velocity.norm());
    return blocks.is_near(job.rank(), s.position, s.radius + s.overlap.norm() + ahead);
  };
  const std::vector<SphereState> started = side.share_out(blocks);
  std::vector<SphereState> mine;
  std::copy_if(started.begin(), started.end(), std::back_inserter(mine),
               [&](const SphereState& s) { return s.mobile && is_home(s); });
  std::vector<SphereState> mobile = gather_by_tag<SphereState>(job.own(), mine);
  if (!std::all_of(started.begin(), started.end(), is_near))
    throw UserError("a rank was told of spheres that are not near its block.");
  side.divide(blocks);

  std::ofstream table;
  if (job.rank() == 0 && !o.out.empty()) table.open(o.out);
  double worst = 0.0, residual = 0.0;
  std::int64_t changes = 0, misrouted = 0, received = 0;
  for (std::int64_t step = 0; step < o.steps; ++step) {
    if (step == o.mistake_at) throw UserError("the stand-in was told to find a mistake.");
    if (step == o.die_at && job.rank() == 0) std::raise(SIGKILL);
    const double dt = step % 2 == 0 ? o.time_step : o.alternate * o.time_step;
    way_time = 8.0 / 15.0 * dt;
    for (int stage = 0; stage < 3; ++stage) {
      std::vector<SphereLoad> loads;
      std::vector<SphereState> expected;
      for (const SphereState& s : mobile) {
        const SphereLoad load = load_on(s, step, stage);
        if (is_home(s)) loads.push_back(load);
        expected.push_back(flown(s, load, DemSteps{}.duration(stage, dt), o));
      }
      side.send_loads(stage, dt, step + 1 == o.steps, loads);
      std::this_thread::sleep_for(std::chrono::duration<double>(o.pressure_seconds));
      const Motion motion = side.receive_motion();
      received += static_cast<std::int64_t>(motion.mobile.size());

      // Each rank got the spheres near its block, all of them and no others.
      std::vector<SphereState> homed, near;
      std::copy_if(motion.mobile.begin(), motion.mobile.end(), std::back_inserter(homed), is_home);
      const auto all = gather_by_tag<SphereState>(job.own(), homed);
      std::copy_if(all.begin(), all.end(), std::back_inserter(near), is_near);
      if (!same_tags(near, motion.mobile)) ++misrouted;
      if (!same_tags(all, mobile)) ++changes;
      for (const SphereState& s : all)
        for (const SphereState& e : expected)
          if (s.tag == e.tag) worst = std::max(worst, difference(s, e, o));
      mobile = all;
      for (const SphereState& s : mobile) check_inside(s, o);
    }
    const StepAccount account = side.settle();
    residual = std::max(residual, account.momentum_residual);
    if (account.mobile != static_cast<std::int64_t>(mobile.size())) ++misrouted;
    for (const SphereState& s : mobile)
      if (table.is_open())
        table << fmt::format("{},{},{},{},{},{}\n", step, s.tag, row(s.position), row(s.velocity),
                             row(s.angular_velocity), row(s.overlap));
  }
  side.stop();
  std::array<std::int64_t, 2> total{misrouted, received};
  MPI_Allreduce(MPI_IN_PLACE, total.data(), 2, MPI_INT64_T, MPI_SUM, job.own());
  if (job.rank() == 0)
    fmt::print("difference={} residual={} changes={} misrouted={} received={} cpu={}\n", worst,
               residual, changes, total[0], total[1], cpu_seconds());
}

}  // namespace
}  // namespace bedload

int main(int argc, char** argv) {
  using namespace bedload;
  return run_program(argc, argv, Program::fluid, exchange_protocol(), [&](Job& job) {
    Options o;
    CLI::App app("stand-in for bedload-fluid");
    app.add_option("--length", o.length)->expected(3);
    app.add_option("--periodic", o.periodic)->expected(3);
    app.add_option("--gravity", o.gravity)->expected(3);
    app.add_option("--time-step", o.time_step);
    app.add_option("--cell-size", o.cell_size);
    app.add_option("--steps", o.steps);
    app.add_option("--pressure-seconds", o.pressure_seconds);
    app.add_option("--alternate", o.alternate);
    app.add_option("--mistake-at", o.mistake_at);
    app.add_option("--die-at", o.die_at);
    app.add_option("--z-parts", o.z_parts);
    app.add_option("--out", o.out);
    app.parse(argc, argv);
    run(job, o);
    return 0;
  });
}
