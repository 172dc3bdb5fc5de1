// A fluid without a flow: takes the place of bedload-fluid in tests of the exchange. It makes up
// the loads by a law that can be summed by hand, follows each sphere along the parabolas that these
// loads give, and compares with what LIGGGHTS sends back.

#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <numbers>
#include <thread>

#include "coupling/fluid_side.hpp"
#include "coupling/roles.hpp"
#include "coupling/stages.hpp"
#include "fluid/errors.hpp"

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
  std::string out;
};

FluidFacts facts_of(const Options& o) {
  FluidFacts facts{};
  for (std::size_t d = 0; d < 3; ++d) {
    facts.length[d] = o.length[d];
    facts.periodic[d] = o.periodic[d];
    facts.gravity[d] = o.gravity[d];
  }
  facts.density = 1000.0;
  facts.kinematic_viscosity = 1e-3;
  facts.time_step = o.time_step;
  facts.cell_size = o.cell_size;
  return facts;
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

double cpu_seconds() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return static_cast<double>(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
}

void run(Job& job, const Options& o) {
  FluidSide side(job);
  side.introduce(facts_of(o));
  const Acquaintance dem = side.meet();

  std::vector<SphereState> mobile;
  for (const SphereState& s : dem.spheres)
    if (s.mobile) mobile.push_back(s);
  if (job.rank() == 0)
    fmt::print("spheres fixed={} mobile={}\n", dem.facts.fixed, dem.facts.mobile);

  std::ofstream table;
  if (job.rank() == 0 && !o.out.empty()) table.open(o.out);
  double worst = 0.0, residual = 0.0;
  int changes = 0;
  for (std::int64_t step = 0; step < o.steps; ++step) {
    if (step == o.mistake_at) throw UserError("the stand-in was told to find a mistake.");
    if (step == o.die_at && job.rank() == 0) std::raise(SIGKILL);
    const double dt = step % 2 == 0 ? o.time_step : o.alternate * o.time_step;
    for (int stage = 0; stage < 3; ++stage) {
      std::vector<SphereLoad> loads;
      std::vector<SphereState> expected;
      for (const SphereState& s : mobile) {
        loads.push_back(load_on(s, step, stage));
        expected.push_back(flown(s, loads.back(), stage_length(stage, dt), o));
      }
      side.send_loads(stage, dt, step + 1 == o.steps, loads);
      std::this_thread::sleep_for(std::chrono::duration<double>(o.pressure_seconds));
      Motion motion = side.receive_motion();
      if (!motion.same_spheres) ++changes;
      residual = std::max(residual, motion.momentum_residual);
      if (motion.same_spheres)
        for (std::size_t i = 0; i < expected.size(); ++i)
          worst = std::max(worst, difference(motion.mobile[i], expected[i], o));
      mobile = std::move(motion.mobile);
      for (const SphereState& s : mobile) check_inside(s, o);
    }
    for (const SphereState& s : mobile)
      if (table.is_open())
        table << fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", step, s.tag, s.position[0],
                             s.position[1], s.position[2], s.velocity[0], s.velocity[1],
                             s.velocity[2], s.angular_velocity[0], s.angular_velocity[1],
                             s.angular_velocity[2]);
  }
  side.stop();
  if (job.rank() == 0)
    fmt::print("difference={} residual={} changes={} cpu={}\n", worst, residual, changes,
               cpu_seconds());
}

}  // namespace
}  // namespace bedload

int main(int argc, char** argv) {
  using namespace bedload;
  return run_program(argc, argv, Program::fluid, [&](Job& job) {
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
    app.add_option("--out", o.out);
    app.parse(argc, argv);
    run(job, o);
  });
}
