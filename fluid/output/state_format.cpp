#include "fluid/output/state_format.hpp"

#include "fluid/output/agreement.hpp"
#include "fluid/output/aside_file.hpp"
#include "fluid/output/front_block.hpp"

namespace bedload {
namespace {

constexpr FrontBlock state_front{"bedload state", state_format_version};

}  // namespace

std::unique_ptr<Hdf5File> create_state(const std::string& path, const StateHeader& header,
                                       MPI_Comm comm) {
  auto file = std::make_unique<Hdf5File>(aside_name(path), Hdf5File::Access::create, comm,
                                         front_block_bytes);
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
  write_front_block(path, state_front, comm);
  on_first_rank(comm, [&] { put_in_place(path); });
}

StateReader::StateReader(const std::string& path, MPI_Comm comm) {
  check_front_block(path, state_front, comm);
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
    if (file_->has("y_faces")) {
      const std::uint64_t n = file_->shape("y_faces")[0];
      header_.y_faces.resize(n);
      file_->read("y_faces", {{n}, {0}, {n}}, header_.y_faces.data());
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
