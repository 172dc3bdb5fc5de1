#include "fluid/output/state_format.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
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

constexpr const char* title = "bedload state";

/// The text in front: three lines, filled up with zeros.
std::string front_text(std::uint64_t bytes, std::uint64_t sum) {
  std::string text =
      fmt::format("{} {}\nbytes {}\nchecksum {:016x}\n", title, state_format_version, bytes, sum);
  text.resize(state_block_bytes, '\0');
  return text;
}

struct Front {
  int version = 0;
  std::uint64_t bytes = 0, sum = 0;
};

Front read_front(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw UserError(fmt::format("{}: the state cannot be opened.", path));
  std::string text(state_block_bytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  Front front;
  std::istringstream words(text.substr(0, text.find('\0')));
  std::string first, second, bytes_word, sum_word;
  words >> first >> second >> front.version >> bytes_word >> front.bytes >> sum_word >> std::hex >>
      front.sum;
  if (!words || first + " " + second != title || bytes_word != "bytes" || sum_word != "checksum")
    throw UserError(fmt::format("{}: is not a state written by bedload.", path));
  return front;
}

/// Refuses what is not exactly the file that was sealed.
void check_front(const std::string& path, MPI_Comm comm) {
  Front front;
  on_first_rank(comm, [&] {
    front = read_front(path);
    if (front.version != state_format_version)
      throw UserError(fmt::format("{}: is a state of format {}, but this program reads format {}.",
                                  path, front.version, state_format_version));
    const std::uint64_t found = std::filesystem::file_size(path);
    const std::uint64_t sealed = front.bytes + state_block_bytes;
    if (found != sealed)
      throw UserError(fmt::format("{}: the state is {}; the file has {} bytes instead of {}.", path,
                                  found < sealed ? "truncated" : "too long", found, sealed));
  });
  const std::uint64_t sum = file_checksum(path, state_block_bytes, comm);
  on_first_rank(comm, [&] {
    if (sum != front.sum)
      throw UserError(
          fmt::format("{}: the state is damaged; its check sum is {:016x} instead of "
                      "{:016x}.",
                      path, sum, front.sum));
  });
}

}  // namespace

std::unique_ptr<Hdf5File> create_state(const std::string& path, const StateHeader& header,
                                       MPI_Comm comm) {
  auto file = std::make_unique<Hdf5File>(aside_name(path), Hdf5File::Access::create, comm,
                                         state_block_bytes);
  std::array<std::int32_t, 6> walls{};
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t e = 0; e < 2; ++e)
      walls[2 * d + e] = static_cast<std::int32_t>(header.walls[d][e]);
  const std::array<std::int32_t, 3> cells{header.cells[0], header.cells[1], header.cells[2]};
  file->set_text("/", "content", "staggered flow, datasets in the order (y, z, x)");
  file->set_attribute<std::int32_t>("/", "cells", cells);
  file->set_attribute<double>("/", "length", header.length);
  file->set_attribute<std::int32_t>("/", "walls", walls);
  file->set_attribute("/", "time", header.time);
  file->set_attribute("/", "step", header.step);
  file->set_attribute("/", "driving", header.driving);
  return file;
}

void seal_state(const std::string& path, const std::string& previous, MPI_Comm comm) {
  const std::string name = aside_name(path);
  const std::uint64_t sum = file_checksum(name, state_block_bytes, comm);
  on_first_rank(comm, [&] {
    const std::string text = front_text(std::filesystem::file_size(name) - state_block_bytes, sum);
    const int file = ::open(name.c_str(), O_WRONLY);
    const bool done = file >= 0 && ::pwrite(file, text.data(), text.size(), 0) ==
                                       static_cast<ssize_t>(text.size());
    const int error = errno;
    if (file >= 0) ::close(file);
    if (!done)
      throw UserError(fmt::format("{}: cannot be written ({}).", path, std::strerror(error)));
    if (previous.empty())
      put_in_place(path);
    else
      put_in_place_keeping(path, previous);
  });
}

StateReader::StateReader(const std::string& path, MPI_Comm comm) {
  check_front(path, comm);
  // Every rank reads on its own: no reader has to wait for another, however the planes fall.
  together(comm, [&] {
    file_ = std::make_unique<Hdf5File>(path, Hdf5File::Access::read, MPI_COMM_SELF);
    const auto cells = file_->attribute<std::int32_t>("/", "cells", 3);
    const auto length = file_->attribute<double>("/", "length", 3);
    const auto walls = file_->attribute<std::int32_t>("/", "walls", 6);
    for (std::size_t d = 0; d < 3; ++d) {
      header_.cells[d] = cells[d];
      header_.length[d] = length[d];
      for (std::size_t e = 0; e < 2; ++e) header_.walls[d][e] = static_cast<Wall>(walls[2 * d + e]);
    }
    header_.time = file_->attribute<double>("/", "time");
    header_.step = file_->attribute<std::int64_t>("/", "step");
    header_.driving = file_->attribute<double>("/", "driving");
    for (std::size_t c = 0; c < state_datasets.size(); ++c)
      if (has(static_cast<int>(c)) && file_->type(state_datasets[c]) == NumberType::int16)
        scale_[c] = file_->attribute<double>(state_datasets[c], "scale");
  });
}

template <class Real>
void StateReader::read_rows(int c, int plane, int first, int count, Real* values) const {
  const auto size = [](int n) { return static_cast<std::uint64_t>(n); };
  const auto& cells = header_.cells;
  const auto component = static_cast<std::size_t>(c);
  const Hyperslab block{{size(cells[1]), size(cells[2]), size(cells[0])},
                        {size(plane), size(first), 0},
                        {1, size(count), size(cells[0])}};
  file_->read(state_datasets[component], block, values);
  if (scale_[component] != 1.0)
    for (std::uint64_t n = 0; n < block.size(); ++n)
      values[n] = static_cast<Real>(scale_[component] * static_cast<double>(values[n]));
}
template void StateReader::read_rows(int, int, int, int, float*) const;
template void StateReader::read_rows(int, int, int, int, double*) const;

StateExtras StateReader::extras() const {
  StateExtras extras;
  if (!file_->has("extra")) return extras;
  for (const std::string& name : file_->names("extra")) {
    const std::uint64_t n = file_->shape("extra/" + name)[0];
    extras[name].resize(n);
    file_->read("extra/" + name, {{n}, {0}, {n}}, extras[name].data());
  }
  return extras;
}

}  // namespace bedload
