#include "coupling/bedload_dem/written_files.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <system_error>

namespace bedload {
namespace {

std::mutex guard;
std::optional<std::string> first_failure;

/// Descriptor of a file that is written to; -1: the file is read, a screen or in memory.
int written(FILE* file) {
  const int before = errno, number = fileno(file);
  const bool screen = number <= STDERR_FILENO;
  const bool read = !screen && (fcntl(number, F_GETFL) & O_ACCMODE) == O_RDONLY;
  errno = before;
  return screen || read ? -1 : number;
}

std::string name_of(int descriptor) {
  std::error_code error;
  return std::filesystem::read_symlink(fmt::format("/proc/self/fd/{}", descriptor), error);
}

void remember(const std::string& name, int error) {
  const std::lock_guard lock(guard);
  if (!first_failure)
    first_failure = fmt::format("{}: cannot be written ({})", name,
                                error != 0 ? std::strerror(error) : "a part is missing");
}

/// A disk that takes no more, or gives up.
bool is_of_a_disk(int error) {
  return error == ENOSPC || error == EDQUOT || error == EFBIG || error == EIO;
}

/// Of write() and writev(), whose result is given.
ssize_t looked_at(int descriptor, ssize_t result) {
  const int error = errno;
  if (result < 0 && is_of_a_disk(error) && descriptor > STDERR_FILENO)
    remember(name_of(descriptor), error);
  errno = error;
  return result;
}

template <class Function>
Function* of_the_library(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

std::optional<std::string> unwritten_file() {
  const std::lock_guard lock(guard);
  return first_failure;
}

}  // namespace bedload

// LIGGGHTS writes with C's functions and does not ask whether they could; VTK, which makes some of
// its dumps, with C++ streams, of which small files fail when nobody asks any more: those end in
// write() and writev(). A program's own functions of these names come before those of the C library
// in all its shared libraries.
extern "C" {

__attribute__((visibility("default"))) ssize_t write(int descriptor, const void* from,
                                                     size_t count) {
  static const auto original = bedload::of_the_library<ssize_t(int, const void*, size_t)>("write");
  return bedload::looked_at(descriptor, original(descriptor, from, count));
}

__attribute__((visibility("default"))) ssize_t writev(int descriptor, const iovec* parts,
                                                      int count) {
  static const auto original = bedload::of_the_library<ssize_t(int, const iovec*, int)>("writev");
  return bedload::looked_at(descriptor, original(descriptor, parts, count));
}

__attribute__((visibility("default"))) int fflush(FILE* file) {
  static const auto original = bedload::of_the_library<int(FILE*)>("fflush");
  const int result = original(file);
  const int error = result != 0 ? errno : 0;
  if (file != nullptr && (result != 0 || ferror(file) != 0))
    if (const int number = bedload::written(file); number >= 0)
      bedload::remember(bedload::name_of(number), error);
  if (error != 0) errno = error;
  return result;
}

__attribute__((visibility("default"))) int fclose(FILE* file) {
  static const auto original = bedload::of_the_library<int(FILE*)>("fclose");
  const int number = bedload::written(file);
  if (number < 0) return original(file);
  const std::string name = bedload::name_of(number);
  const bool flushed = fflush(file) == 0;  // else the close has nothing left to fail with
  const int flush_error = errno;
  const bool closed = original(file) == 0;
  const int error = flushed ? errno : flush_error;
  if (!closed) bedload::remember(name, error);
  errno = error;
  return flushed && closed ? 0 : EOF;
}
}
