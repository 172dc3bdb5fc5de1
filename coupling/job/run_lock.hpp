#pragma once

#include <string>

namespace bedload {

/// OUT/run.lock says whose the output folder OUT is while a run writes there: host, process, job of
/// the batch system. The file is held by flock(2), which the system gives up with the process,
/// however that ends; a file that nobody holds is stale and taken over. Where a file system knows
/// no such locks, a process of this machine is looked up by its number and begin, and one of
/// another machine counts as alive, unless it belongs to this batch job (which was started anew).
///
/// For one rank. Removed by the destructor, when the run has come to its end.
class RunLock {
 public:
  /// Throws UserError that names the holder when another run has the folder.
  explicit RunLock(const std::string& out);
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  std::string path_;
  int file_ = -1;
};

}  // namespace bedload
