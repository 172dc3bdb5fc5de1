#pragma once

namespace bedload {

/// How long the programs of a job may take to start [s], by the environment that mpirun or srun
/// gives to them; 0: for ever.
double start_limit_in_seconds();

/// MPI starts when every process of the job asks for it, so a partner that never does would be
/// waited for without end. While an object of this kind lives, the process ends with a sentence
/// when that takes too long: seven seconds on one machine, more in proportion where more processes
/// want to run than it has cores; two minutes on several machines, which load programs over a
/// network. The environment variable BEDLOAD_START_LIMIT sets another time [s]; 0: none.
class StartLimit {
 public:
  explicit StartLimit(const char* program);
  ~StartLimit();
  StartLimit(const StartLimit&) = delete;
  StartLimit& operator=(const StartLimit&) = delete;
};

}  // namespace bedload
