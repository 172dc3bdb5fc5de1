#include "coupling/job/start_limit.hpp"

#include <fmt/format.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>

namespace bedload {
namespace {

std::string sentence;  // a handler reaches nothing but static storage

void give_up(int) {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, sentence.data(), sentence.size());
  ::_exit(1);
}

/// A number of the environment; `otherwise` where there is none.
double number_of(const char* variable, double otherwise) {
  const char* const text = std::getenv(variable);
  if (!text) return otherwise;
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  return end != text && std::isfinite(value) && value >= 0.0 ? value : otherwise;
}

/// Processes of the job and those of them on this machine, as mpirun or Slurm's srun tell them.
struct Crowd {
  double all, here;
};

Crowd crowd_of_job() {
  const double by_mpirun = number_of("OMPI_COMM_WORLD_SIZE", 0.0);
  if (by_mpirun > 0.0) return {by_mpirun, number_of("OMPI_COMM_WORLD_LOCAL_SIZE", by_mpirun)};
  // srun tells how many there are on each machine as "4(x2),3"; the first number will do.
  const double by_srun = number_of("SLURM_STEP_NUM_TASKS", 1.0);
  return {by_srun, std::min(by_srun, number_of("SLURM_STEP_TASKS_PER_NODE", by_srun))};
}

void set_timer(double seconds) {
  const double whole = std::floor(seconds);
  const itimerval timer{
      {0, 0}, {static_cast<time_t>(whole), static_cast<suseconds_t>(1e6 * (seconds - whole))}};
  ::setitimer(ITIMER_REAL, &timer, nullptr);
}

}  // namespace

double start_limit_in_seconds() {
  constexpr double one_machine = 7.0, several_machines = 120.0;
  const Crowd crowd = crowd_of_job();
  double load = 0.0;
  if (::getloadavg(&load, 1) != 1) load = 0.0;
  const double cores = std::max(1u, std::thread::hardware_concurrency());
  const double share = std::max({1.0, (load + crowd.here) / cores});
  return number_of("BEDLOAD_START_LIMIT",
                   crowd.here < crowd.all ? several_machines : one_machine * share);
}

StartLimit::StartLimit(const char* program) {
  const double seconds = start_limit_in_seconds();
  if (seconds == 0.0) return;
  sentence = fmt::format(
      "\n{}: not every program of the job has started within {:.0f} s (BEDLOAD_START_LIMIT); start "
      "both from one build, mpirun -np N bedload-fluid fluid.toml : -np M bedload-dem -in "
      "in.liggghts\n",
      program, seconds);
  std::signal(SIGALRM, give_up);
  // One after the other: the first ends the job, and a second later mpirun ends the others.
  const double rank = number_of("OMPI_COMM_WORLD_RANK", number_of("SLURM_PROCID", 0.0));
  set_timer(seconds + 1.5 * std::min(rank, 2.0));
}

StartLimit::~StartLimit() {
  set_timer(0.0);
  std::signal(SIGALRM, SIG_DFL);
}

}  // namespace bedload
