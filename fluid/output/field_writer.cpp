#include "fluid/output/field_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

#include "fluid/files/atomic_file.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/files/hdf5_file.hpp"
#include "fluid/files/resumable_file.hpp"

namespace bedload {
namespace {

constexpr std::uint64_t metadata_room = 1 << 20;  // groups, headers and alignment of one snapshot

std::string group_name(std::int64_t step) { return fmt::format("step_{:08d}", step); }

std::vector<double> faces(const Grid& grid, std::size_t d) {
  std::vector<double> position;
  for (int i = -1; i < grid.cells[d]; ++i)
    position.push_back(d == 1 ? grid.y_face(i) : grid.face(i));
  return position;
}

/// This rank's share of an array of shape (nz, ny, nx).
Hyperslab slab_of(const Grid& grid, const Decomposition& decomposition) {
  const auto size = [](int n) { return static_cast<std::uint64_t>(n); };
  return {{size(grid.cells[2]), size(grid.cells[1]), size(grid.cells[0])},
          {size(decomposition.first_row()), size(decomposition.first()), 0},
          {size(decomposition.rows()), size(decomposition.planes()), size(grid.cells[0])}};
}

/// A quantity at the centres of this rank's cells in rows first .. first+rows-1, order (k, j, i):
/// one that lives on faces as u(i, j, k) = (u_{i-1/2} + u_{i+1/2}) / 2, one at the centres as it
/// is.
template <class Real>
void centred(const FlowView<Real>& flow, const FieldEntry& entry, int first, int rows, float* to) {
  const std::array<int, 3> lower_face{entry.on_face(0), entry.on_face(1), entry.on_face(2)};
  for (int k = first; k < first + rows; ++k)
    for (int j = 0; j < flow.decomposition.planes(); ++j) {
      const Real* upper = flow.fields.row(entry, j, k);
      const Real* lower =
          flow.fields.row(entry, j - lower_face[1], k - lower_face[2]) - lower_face[0];
      for (int i = 0; i < flow.grid.cells[0]; ++i)
        *to++ = static_cast<float>(Real(0.5) * (lower[i] + upper[i]));
    }
}

constexpr auto fields_per_snapshot = static_cast<std::uint64_t>(std::count_if(
    field_list.begin(), field_list.end(), [](const FieldEntry& entry) { return entry.in_output; }));

}  // namespace

FieldWriter::FieldWriter(const std::string& folder, const Grid& grid,
                         const Decomposition& decomposition, std::int64_t resume_after)
    : folder_(folder), path_(folder + "/fields.h5"), grid_(grid), comm_(decomposition.comm()) {
  on_first_rank(comm_, [&] {
    if (resume_after < 0 || !resume_or_set_aside(path_, [&] { resume_file(resume_after); }))
      create_file();
    write_xdmf();
  });
  int count = static_cast<int>(snapshots_.size());
  MPI_Bcast(&count, 1, MPI_INT, 0, comm_);
  snapshots_.resize(static_cast<std::size_t>(count));
  MPI_Bcast(snapshots_.data(), static_cast<int>(snapshots_.size() * sizeof(Snapshot)), MPI_BYTE, 0,
            comm_);
}

void FieldWriter::create_file() {
  require_space(path_, metadata_room);
  Hdf5File file(temporary_name(path_), Hdf5File::Access::create, MPI_COMM_SELF);
  file.make_group("grid");
  for (std::size_t d = 0; d < 3; ++d) {
    const std::vector<double> position = faces(grid_, d);
    const std::uint64_t n = position.size();
    file.write(fmt::format("grid/{}", "xyz"[d]), {{n}, {0}, {n}}, position.data());
  }
  file.close();
  mark_whole(path_);
}

void FieldWriter::resume_file(std::int64_t step) {
  snapshots_.clear();
  mark_unfinished(path_);
  Hdf5File file(temporary_name(path_), Hdf5File::Access::append, MPI_COMM_SELF);
  for (const std::string& name : file.names("/")) {
    if (!name.starts_with("step_")) continue;
    const Snapshot snapshot{file.attribute<std::int64_t>(name, "step"),
                            file.attribute<double>(name, "time")};
    if (snapshot.step <= step)
      snapshots_.push_back(snapshot);
    else
      file.remove(name);
  }
  // Names come in the order of letters.
  std::ranges::sort(snapshots_, {}, &Snapshot::step);
  file.close();
  mark_whole(path_);
}

template <class Real>
void FieldWriter::write(const FlowView<Real>& flow) {
  const Hyperslab slab = slab_of(flow.grid, flow.decomposition);
  on_first_rank(comm_, [&] {
    const auto cells = static_cast<std::uint64_t>(grid_.cell_count());
    require_space(path_, cells * fields_per_snapshot * sizeof(float) + metadata_room);
    mark_unfinished(path_);
  });
  Hdf5File file(temporary_name(path_), Hdf5File::Access::append, comm_);
  const std::string group = group_name(flow.step);
  if (std::erase_if(snapshots_, [&](const Snapshot& s) { return s.step == flow.step; }) > 0)
    file.remove(group);
  file.make_group(group);
  file.set_attribute(group, "step", flow.step);
  file.set_attribute(group, "time", flow.time);
  for (const FieldEntry& entry : field_list) {
    if (!entry.in_output) continue;
    const std::string name = fmt::format("{}/{}", group, entry.name);
    file.write_in_pieces<float>(
        name, slab, [&](int first, int rows, float* to) { centred(flow, entry, first, rows, to); });
    file.set_text(name, "unit", entry.unit);
  }
  file.close();
  snapshots_.push_back({flow.step, flow.time});
  on_first_rank(comm_, [&] {
    mark_whole(path_);
    write_xdmf();
  });
}

void FieldWriter::write_xdmf() const {
  const int nx = grid_.cells[0], ny = grid_.cells[1], nz = grid_.cells[2];
  std::string text =
      "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\">\n<Domain>\n"
      "<Grid Name=\"flow\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const Snapshot& snapshot : snapshots_) {
    const std::string group = group_name(snapshot.step);
    text += fmt::format(
        "<Grid Name=\"{0}\" GridType=\"Uniform\">\n<Time Value=\"{1}\"/>\n"
        "<Topology TopologyType=\"3DRectMesh\" Dimensions=\"{4} {3} {2}\"/>\n"
        "<Geometry GeometryType=\"VXVYVZ\">\n",
        group, snapshot.time, nx + 1, ny + 1, nz + 1);
    for (std::size_t d = 0; d < 3; ++d)
      text += fmt::format(
          "<DataItem Dimensions=\"{}\" NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">"
          "fields.h5:/grid/{}</DataItem>\n",
          grid_.cells[d] + 1, "xyz"[d]);
    text += "</Geometry>\n";
    for (const FieldEntry& entry : field_list) {
      if (!entry.in_output) continue;
      text += fmt::format(
          "<Attribute Name=\"{0}\" AttributeType=\"Scalar\" Center=\"Cell\">"
          "<DataItem Dimensions=\"{4} {3} {2}\" NumberType=\"Float\" Precision=\"4\" "
          "Format=\"HDF\">fields.h5:/{1}/{0}</DataItem></Attribute>\n",
          entry.name, group, nx, ny, nz);
    }
    text += "</Grid>\n";
  }
  text += "</Grid>\n</Domain>\n</Xdmf>\n";
  write_text_file(folder_ + "/fields.xdmf", text);
}

template void FieldWriter::write(const FlowView<float>&);
template void FieldWriter::write(const FlowView<double>&);

}  // namespace bedload
