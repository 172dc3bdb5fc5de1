// How long the programs of a job wait for each other at the start, by what mpirun or srun tells
// them; how they sleep while they wait.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "coupling/job/start_limit.hpp"
#include "coupling/job/wait.hpp"

namespace bedload {
namespace {

/// The limit where the environment has these variables of mpirun and Slurm, and no others.
double limit(const std::vector<std::pair<std::string, std::string>>& environment) {
  for (const char* name :
       {"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_SIZE", "SLURM_STEP_NUM_TASKS",
        "SLURM_STEP_TASKS_PER_NODE", "BEDLOAD_START_LIMIT"})
    ::unsetenv(name);
  for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
  return start_limit_in_seconds();
}

constexpr double several_machines = 120.0;

TEST(StartLimit, KnowsSeveralMachines) {
  EXPECT_EQ(limit({{"OMPI_COMM_WORLD_SIZE", "8"}, {"OMPI_COMM_WORLD_LOCAL_SIZE", "4"}}),
            several_machines);
  EXPECT_EQ(limit({{"SLURM_STEP_NUM_TASKS", "8"}, {"SLURM_STEP_TASKS_PER_NODE", "4(x2)"}}),
            several_machines);
  EXPECT_EQ(limit({{"SLURM_STEP_NUM_TASKS", "7"}, {"SLURM_STEP_TASKS_PER_NODE", "4,3"}}),
            several_machines);
}

TEST(StartLimit, IsShortOnOne) {
  const double one = limit({});
  EXPECT_GE(one, 7.0);
  // Mpirun on one machine within a batch job of several steps on many.
  EXPECT_NE(limit({{"OMPI_COMM_WORLD_SIZE", "2"},
                   {"OMPI_COMM_WORLD_LOCAL_SIZE", "2"},
                   {"SLURM_STEP_NUM_TASKS", "8"},
                   {"SLURM_STEP_TASKS_PER_NODE", "4(x2)"}}),
            several_machines);
  EXPECT_NE(limit({{"SLURM_STEP_NUM_TASKS", "2"}, {"SLURM_STEP_TASKS_PER_NODE", "2"}}),
            several_machines);
  EXPECT_EQ(limit({{"SLURM_STEP_NUM_TASKS", "8"}, {"BEDLOAD_START_LIMIT", "3"}}), 3.0);
}

/// Sleeps of a wait, and how long all of them together are, in ns.
std::pair<int, std::int64_t> sleeps_of(std::int64_t wait) {
  int sleeps = 0;
  std::int64_t last = 2'000, slept = 0;
  while (slept < wait) {
    slept += last;
    last = next_sleep(last, slept);
    ++sleeps;
  }
  return {sleeps, slept};
}

TEST(Wait, IsFewSleepsAndHardlyTooLong) {
  const std::int64_t millisecond = 1'000'000;
  EXPECT_EQ(next_sleep(2'000, 2'000), 4'000);
  EXPECT_EQ(next_sleep(millisecond / 10, millisecond), millisecond / 10);
  EXPECT_EQ(next_sleep(3 * millisecond, 128 * millisecond), 4 * millisecond);
  EXPECT_EQ(next_sleep(20 * millisecond, 10'000 * millisecond), 20 * millisecond);
  for (const std::int64_t wait : {1, 10, 100, 600}) {
    const auto [sleeps, slept] = sleeps_of(wait * millisecond);
    EXPECT_LE(slept, wait * millisecond + std::max(millisecond / 10, wait * millisecond / 32));
    EXPECT_LE(sleeps, 40 + 32 * std::log(static_cast<double>(wait))) << wait << " ms";
  }
  // A minute: one in 20 ms, so that a checkpoint that is asked for is not late.
  EXPECT_NEAR(sleeps_of(60'000 * millisecond).first, 3000, 300);
}

}  // namespace
}  // namespace bedload
