#include "fluid/output/front_block.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "fluid/errors.hpp"
#include "fluid/output/agreement.hpp"
#include "fluid/output/aside_file.hpp"
#include "fluid/output/checksum.hpp"

namespace bedload {
namespace {

/// Three lines, filled up with zeros.
std::string front_text(const FrontBlock& block, std::uint64_t bytes, std::uint64_t sum) {
  std::string text =
      fmt::format("{} {}\nbytes {}\nchecksum {:016x}\n", block.kind, block.version, bytes, sum);
  text.resize(front_block_bytes, '\0');
  return text;
}

struct Front {
  int version = 0;
  std::uint64_t bytes = 0, sum = 0;
};

/// Every byte counts: a block that is not exactly what a writer makes of its numbers is refused.
Front read_front(const std::string& path, const FrontBlock& block) {
  std::error_code error;  // a pipe or a device might never end
  const bool plain = std::filesystem::is_regular_file(path, error);
  std::ifstream file;
  if (plain) file.open(path, std::ios::binary);
  if (!plain || !file) throw UserError(fmt::format("{}: the state cannot be opened.", path));
  std::string text(front_block_bytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  Front front;
  std::istringstream words(text.substr(0, text.find('\0')));
  std::string first, second, bytes_word, sum_word;
  words >> first >> second >> front.version >> bytes_word >> front.bytes >> sum_word >> std::hex >>
      front.sum;
  if (!words || text != front_text({block.kind, front.version}, front.bytes, front.sum))
    throw UserError(fmt::format("{}: is not a state written by bedload.", path));
  return front;
}

}  // namespace

void write_front_block(const std::string& path, const FrontBlock& block, MPI_Comm comm) {
  const std::string name = aside_name(path);
  const std::uint64_t sum = file_checksum(name, front_block_bytes, comm);
  on_first_rank(comm, [&] {
    const std::string text =
        front_text(block, std::filesystem::file_size(name) - front_block_bytes, sum);
    const int file = ::open(name.c_str(), O_WRONLY);
    const bool done = file >= 0 && ::pwrite(file, text.data(), text.size(), 0) ==
                                       static_cast<ssize_t>(text.size());
    const int error = errno;
    if (file >= 0) ::close(file);
    if (!done)
      throw UserError(fmt::format("{}: cannot be written ({}).", path, std::strerror(error)));
  });
}

void check_front_block(const std::string& path, const FrontBlock& block, MPI_Comm comm) {
  Front front;
  on_first_rank(comm, [&] {
    front = read_front(path, block);
    if (front.version != block.version)
      throw UserError(fmt::format("{}: is a state of format {}, but this program reads format {}.",
                                  path, front.version, block.version));
    const std::uint64_t found = std::filesystem::file_size(path);
    const std::uint64_t sealed = front.bytes + front_block_bytes;
    if (found != sealed)
      throw UserError(fmt::format("{}: the state is {}; the file has {} bytes instead of {}.", path,
                                  found < sealed ? "truncated" : "too long", found, sealed));
  });
  const std::uint64_t sum = file_checksum(path, front_block_bytes, comm);
  on_first_rank(comm, [&] {
    if (sum != front.sum)
      throw UserError(
          fmt::format("{}: the state is damaged; its check sum is {:016x} instead of "
                      "{:016x}.",
                      path, sum, front.sum));
  });
}

}  // namespace bedload
