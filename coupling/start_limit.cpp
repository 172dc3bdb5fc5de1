#include "coupling/start_limit.hpp"

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

double limit_in_seconds() {
  constexpr double one_machine = 7.0, several_machines = 120.0;
  const double all = number_of("OMPI_COMM_WORLD_SIZE", 1.0);
  const double here = number_of("OMPI_COMM_WORLD_LOCAL_SIZE", all);
  double load = 0.0;
  if (::getloadavg(&load, 1) != 1) load = 0.0;
  const double cores = std::max(1u, std::thread::hardware_concurrency());
  const double crowd = std::max({1.0, (load + here) / cores});
  return number_of("BEDLOAD_START_LIMIT", here < all ? several_machines : one_machine * crowd);
}

void set_timer(double seconds) {
  const double whole = std::floor(seconds);
  const itimerval timer{
      {0, 0}, {static_cast<time_t>(whole), static_cast<suseconds_t>(1e6 * (seconds - whole))}};
  ::setitimer(ITIMER_REAL, &timer, nullptr);
}

}  // namespace

StartLimit::StartLimit(const char* program) {
  const double seconds = limit_in_seconds();
  if (seconds == 0.0) return;
  sentence = fmt::format(
      "\n{}: not every program of the job has started within {:.0f} s (BEDLOAD_START_LIMIT); start "
      "both from one build, mpirun -np N bedload-fluid fluid.toml : -np M bedload-dem -in "
      "in.liggghts\n",
      program, seconds);
  std::signal(SIGALRM, give_up);
  // One after the other: the first ends the job, and a second later mpirun ends the others.
  set_timer(seconds + 1.5 * std::min(number_of("OMPI_COMM_WORLD_RANK", 0.0), 2.0));
}

StartLimit::~StartLimit() {
  set_timer(0.0);
  std::signal(SIGALRM, SIG_DFL);
}

}  // namespace bedload
