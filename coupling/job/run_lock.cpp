#include "coupling/job/run_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "coupling/job/machine.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

/// Who writes in a folder.
struct Holder {
  std::string host, machine, job;
  int process = 0;
  unsigned long long began = 0;  ///< see process_start()
};

/// The number that the batch system gave this job; empty outside of one.
std::string batch_job() {
  for (const char* name : {"SLURM_JOB_ID", "PBS_JOBID", "LSB_JOBID", "JOB_ID"})
    if (const char* number = std::getenv(name); number && *number)
      return fmt::format("{} {}", name, number);
  return {};
}

Holder myself() {
  const int process = ::getpid();
  return {host_name(), machine_identity(), batch_job(), process, process_start(process)};
}

/// One `name = value` a line.
std::string text_of(const Holder& holder) {
  return fmt::format("host = {}\nmachine = {}\nprocess = {}\nbegan = {}\njob = {}\n", holder.host,
                     holder.machine, holder.process, holder.began, holder.job);
}

Holder read_holder(const std::string& path) {
  Holder holder;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const auto at = line.find(" = ");
    if (at == std::string::npos) continue;
    const std::string name = line.substr(0, at), value = line.substr(at + 3);
    if (name == "host") holder.host = value;
    if (name == "machine") holder.machine = value;
    if (name == "job") holder.job = value;
    if (name == "process") holder.process = std::atoi(value.c_str());
    if (name == "began") holder.began = std::strtoull(value.c_str(), nullptr, 10);
  }
  return holder;
}

/// By what the file says, where the file system does not know who holds it.
bool is_alive(const Holder& holder) {
  if (holder.process == 0) return false;  // a file that was never filled
  const Holder me = myself();
  if (holder.machine == me.machine)
    return holder.process != me.process && process_start(holder.process) == holder.began;
  return holder.job.empty() || holder.job != me.job;
}

[[noreturn]] void refuse(const std::string& path) {
  const Holder holder = read_holder(path);
  throw UserError(fmt::format(
      "{}: another run writes in this folder, process {} on {}{}; wait for its end, or give this "
      "one another folder with --out. If that run is gone for certain, remove the file.",
      path, holder.process, holder.host,
      holder.job.empty() ? "" : fmt::format(" ({})", holder.job)));
}

bool knows_no_locks(int error) {
  return error == ENOLCK || error == ENOSYS || error == EOPNOTSUPP || error == EINVAL;
}

/// Whether `path` still is the file that was opened: its holder may have removed it in between.
bool is_in_place(int file, const std::string& path) {
  struct stat opened {
  }, there{};
  return ::fstat(file, &opened) == 0 && ::stat(path.c_str(), &there) == 0 &&
         opened.st_ino == there.st_ino && opened.st_dev == there.st_dev;
}

}  // namespace

RunLock::RunLock(const std::string& out) : path_(out + "/run.lock") {
  const auto fail = [this](int error) {
    if (file_ >= 0) ::close(file_);
    throw UserError(fmt::format("{}: cannot be written ({}).", path_, std::strerror(error)));
  };
  for (;;) {
    file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file_ < 0) fail(errno);
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
      const int error = errno;
      if (!knows_no_locks(error) && error != EWOULDBLOCK) fail(error);
      if (error == EWOULDBLOCK || is_alive(read_holder(path_))) {
        ::close(file_);
        refuse(path_);
      }
    }
    if (is_in_place(file_, path_)) break;
    ::close(file_);
  }
  const std::string text = text_of(myself());
  if (::ftruncate(file_, 0) != 0 ||
      ::pwrite(file_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()))
    fail(errno);
}

RunLock::~RunLock() {
  ::unlink(path_.c_str());
  ::close(file_);
}

}  // namespace bedload
