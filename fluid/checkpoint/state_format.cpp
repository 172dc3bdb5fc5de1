#include "fluid/checkpoint/state_format.hpp"

#include <fmt/format.h>

#include <cmath>

#include "fluid/files/atomic_file.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/files/file_header.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

constexpr FileHeader state_file_header{"bedload state", state_format_version};

/// The file says what it was sealed with, but not every program that seals one is this one.
void check_header(const std::string& path, const StateHeader& header) {
  const auto refuse = [&](const char* what) {
    throw UserError(fmt::format("{}: the state's {}.", path, what));
  };
  for (std::size_t d = 0; d < 3; ++d) {
    if (header.cells[d] < 1) refuse("'cells' are not all positive");
    if (!(header.length[d] > 0.0) || std::isinf(header.length[d]))
      refuse("'length' is not positive and finite along each direction");
    for (const Wall wall : header.walls[d])
      if (wall != Wall::periodic && wall != Wall::no_slip && wall != Wall::free_slip)
        refuse("'walls' are of no kind that there is");
  }
  const std::vector<double>& faces = header.y_faces;
  if (faces.empty()) return;
  if (faces.size() != static_cast<std::size_t>(header.cells[1]) + 1)
    refuse("'y_faces' are not one more than its cells along y");
  for (std::size_t j = 1; j < faces.size(); ++j)
    if (!(faces[j] > faces[j - 1])) refuse("'y_faces' do not ascend");
}

}  // namespace

std::unique_ptr<Hdf5File> create_state(const std::string& path, const StateHeader& header,
                                       MPI_Comm comm) {
  auto file = std::make_unique<Hdf5File>(temporary_name(path), Hdf5File::Access::create, comm,
                                         file_header_bytes);
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
  if (const std::uint64_t n = header.y_faces.size(); n > 0) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    file->write("y_faces", {{n}, {0}, {rank == 0 ? n : 0}}, header.y_faces.data());
  }
  return file;
}

void seal_state(const std::string& path, MPI_Comm comm) {
  write_file_header(path, state_file_header, comm);
  on_first_rank(comm, [&] { commit_file(path); });
}

StateReader::StateReader(const std::string& path, MPI_Comm comm) : path_(path) {
  check_file_header(path, state_file_header, comm);
  // Every rank reads on its own: no reader has to wait for another, however the planes fall.
  collectively(comm, [&] {
    file_ = std::make_unique<Hdf5File>(path, Hdf5File::Access::read, MPI_COMM_SELF);
    const auto cells = file_->attribute<std::int32_t>("/", "cells", 3);
    const auto length = file_->attribute<double>("/", "length", 3);
    const auto walls = file_->attribute<std::int32_t>("/", "walls", 6);
    for (std::size_t d = 0; d < 3; ++d) {
      header_.cells[d] = cells[d];
      header_.length[d] = length[d];
      for (std::size_t e = 0; e < 2; ++e) header_.walls[d][e] = static_cast<Wall>(walls[2 * d + e]);
    }
    if (file_->has("y_faces")) {
      const std::vector<std::uint64_t> shape = file_->shape("y_faces");
      if (shape.size() != 1)
        throw UserError(fmt::format("{}: the state's 'y_faces' are not a list.", path));
      const std::uint64_t n = shape[0];
      header_.y_faces.resize(n);
      file_->read("y_faces", {{n}, {0}, {n}}, header_.y_faces.data());
    }
    header_.time = file_->attribute<double>("/", "time");
    header_.step = file_->attribute<std::int64_t>("/", "step");
    header_.driving = file_->attribute<double>("/", "driving");
    check_header(path, header_);
    for (const FieldEntry& entry : field_list)
      if (entry.in_restart && has(entry) && file_->type(entry.name) == NumberType::int16)
        scale_[entry.name] = file_->attribute<double>(entry.name, "scale");
  });
}

template <class Real>
void StateReader::read_rows(const FieldEntry& entry, int plane, int first, int count,
                            Real* values) const {
  const auto size = [](int n) { return static_cast<std::uint64_t>(n); };
  const auto& cells = header_.cells;
  const Hyperslab block{{size(cells[1]), size(cells[2]), size(cells[0])},
                        {size(plane), size(first), 0},
                        {1, size(count), size(cells[0])}};
  file_->read(entry.name, block, values);
  if (const auto scale = scale_.find(entry.name); scale != scale_.end())
    for (std::uint64_t n = 0; n < block.size(); ++n)
      values[n] = static_cast<Real>(scale->second * static_cast<double>(values[n]));
}
template void StateReader::read_rows(const FieldEntry&, int, int, int, float*) const;
template void StateReader::read_rows(const FieldEntry&, int, int, int, double*) const;

}  // namespace bedload
