#include "fluid/files/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

[[noreturn]] void fail(const std::string& path, const char* verb, int error) {
  throw UserError(fmt::format("{}: cannot be {} ({}).", path, verb, std::strerror(error)));
}

/// An open POSIX file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

void force_to_disk(const std::string& name, const std::string& path) {
  const Descriptor file(::open(name.c_str(), O_RDONLY));
  if (file.number() < 0 || ::fsync(file.number()) != 0) fail(path, "written", errno);
}

}  // namespace

std::string temporary_name(const std::string& path) { return path + ".part"; }

void commit_file(const std::string& path) {
  force_to_disk(temporary_name(path), path);
  if (::rename(temporary_name(path).c_str(), path.c_str()) != 0) fail(path, "written", errno);
  // The new name itself is only safe once its folder is; some file systems cannot sync a folder.
  const Descriptor folder(::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY));
  if (folder.number() >= 0) ::fsync(folder.number());
}

void commit_link(const std::string& existing, const std::string& path) {
  discard_temporary(path);
  std::error_code error;
  std::filesystem::create_hard_link(existing, temporary_name(path), error);
  if (error) std::filesystem::copy_file(existing, temporary_name(path), error);
  if (error) fail(path, "written", error.value());
  commit_file(path);
  discard_temporary(path);  // rename leaves both names where they were links to one file already
}

void discard_temporary(const std::string& path) noexcept { ::unlink(temporary_name(path).c_str()); }

void mark_unfinished(const std::string& path) {
  if (::rename(path.c_str(), temporary_name(path).c_str()) != 0) fail(path, "written", errno);
}

void mark_whole(const std::string& path) {
  if (::rename(temporary_name(path).c_str(), path.c_str()) != 0) fail(path, "written", errno);
}

bool find_resumable(const std::string& path) {
  if (::access(path.c_str(), F_OK) == 0) return true;
  if (::access(temporary_name(path).c_str(), F_OK) != 0) return false;
  mark_whole(path);
  return true;
}

std::string rename_damaged_file(const std::string& path) {
  std::string kept = path + ".torn";
  if (::rename(path.c_str(), kept.c_str()) != 0) fail(kept, "written", errno);
  return kept;
}

void write_text_file(const std::string& path, const std::string& text) {
  const std::string name = temporary_name(path);
  try {
    const Descriptor file(::open(name.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666));
    if (file.number() < 0) fail(path, "written", errno);
    std::size_t done = 0;
    while (done < text.size()) {
      const ssize_t count = ::write(file.number(), text.data() + done, text.size() - done);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail(path, "written", errno);
      done += static_cast<std::size_t>(count);
    }
    commit_file(path);
  } catch (const UserError&) {
    discard_temporary(path);
    throw;
  }
}

void require_space(const std::string& path, std::uint64_t bytes) {
  const std::string name = path + ".space";
  const Descriptor file(::open(name.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666));
  if (file.number() < 0) fail(path, "written", errno);
  int error = 0;
  if (bytes > 0 && ::fallocate(file.number(), 0, 0, static_cast<off_t>(bytes)) != 0) error = errno;
  ::unlink(name.c_str());
  if (error == EOPNOTSUPP || error == ENOSYS) {  // NFS and the like: ask instead
    struct statvfs disk {};
    if (::fstatvfs(file.number(), &disk) != 0)
      error = errno;
    else
      error = std::uint64_t{disk.f_bavail} * disk.f_frsize < bytes ? ENOSPC : 0;
  }
  if (error != 0) fail(path, "written", error);
}

}  // namespace bedload
