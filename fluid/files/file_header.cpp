#include "fluid/files/file_header.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "fluid/files/atomic_file.hpp"
#include "fluid/files/checksum.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

/// Three lines, filled up with zeros.
std::string header_text(const FileHeader& block, std::uint64_t bytes, std::uint64_t sum) {
  std::string text =
      fmt::format("{} {}\nbytes {}\nchecksum {:016x}\n", block.kind, block.version, bytes, sum);
  text.resize(file_header_bytes, '\0');
  return text;
}

struct Numbers {
  int version = 0;
  std::uint64_t bytes = 0, sum = 0;
};

/// Every byte counts: a block that is not exactly what a writer makes of its numbers is refused.
Numbers read_header(const std::string& path, const FileHeader& block) {
  std::error_code error;  // a pipe or a device might never end
  const bool plain = std::filesystem::is_regular_file(path, error);
  std::ifstream file;
  if (plain) file.open(path, std::ios::binary);
  if (!plain || !file) throw UserError(fmt::format("{}: the state cannot be opened.", path));
  std::string text(file_header_bytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  Numbers stated;
  std::istringstream words(text.substr(0, text.find('\0')));
  std::string first, second, bytes_word, sum_word;
  words >> first >> second >> stated.version >> bytes_word >> stated.bytes >> sum_word >>
      std::hex >> stated.sum;
  if (!words || text != header_text({block.kind, stated.version}, stated.bytes, stated.sum))
    throw UserError(fmt::format("{}: is not a state written by bedload.", path));
  return stated;
}

}  // namespace

void write_file_header(const std::string& path, const FileHeader& block, MPI_Comm comm) {
  const std::string name = temporary_name(path);
  const std::uint64_t sum = file_checksum(name, file_header_bytes, comm);
  on_first_rank(comm, [&] {
    const std::string text =
        header_text(block, std::filesystem::file_size(name) - file_header_bytes, sum);
    const int file = ::open(name.c_str(), O_WRONLY);
    const bool done = file >= 0 && ::pwrite(file, text.data(), text.size(), 0) ==
                                       static_cast<ssize_t>(text.size());
    const int error = errno;
    if (file >= 0) ::close(file);
    if (!done)
      throw UserError(fmt::format("{}: cannot be written ({}).", path, std::strerror(error)));
  });
}

void check_file_header(const std::string& path, const FileHeader& block, MPI_Comm comm) {
  Numbers stated;
  on_first_rank(comm, [&] {
    stated = read_header(path, block);
    if (stated.version != block.version)
      throw UserError(fmt::format("{}: is a state of format {}, but this program reads format {}.",
                                  path, stated.version, block.version));
    const std::uint64_t found = std::filesystem::file_size(path);
    const std::uint64_t sealed = stated.bytes + file_header_bytes;
    if (found != sealed)
      throw UserError(fmt::format("{}: the state is {}; the file has {} bytes instead of {}.", path,
                                  found < sealed ? "truncated" : "too long", found, sealed));
  });
  const std::uint64_t sum = file_checksum(path, file_header_bytes, comm);
  on_first_rank(comm, [&] {
    if (sum != stated.sum)
      throw UserError(
          fmt::format("{}: the state is damaged; its check sum is {:016x} instead of "
                      "{:016x}.",
                      path, sum, stated.sum));
  });
}

}  // namespace bedload
