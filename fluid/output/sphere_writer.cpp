#include "fluid/output/sphere_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_map>

#include "fluid/files/atomic_file.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/files/hdf5_file.hpp"
#include "fluid/files/resumable_file.hpp"

namespace bedload {
namespace {

constexpr std::uint64_t rows_per_chunk = 1024;
constexpr std::uint64_t metadata_room = 1 << 20;
constexpr std::size_t largest_batch = 100000;  // rows: about 15 MB
constexpr std::size_t xdmf_samples = 1000;     // ParaView's time slider; spheres.h5 holds all

/// The samples of forces on fixed spheres, a row each.
constexpr std::array force_columns{"fixed/force_step", "fixed/force_time", "fixed/force"};

void push(std::vector<double>& column, const Vec3& value) {
  column.insert(column.end(), value.data(), value.data() + 3);
}

std::string data_item(const std::string& name, std::uint64_t rows, int width, const char* type,
                      int precision) {
  return fmt::format(
      "<DataItem Dimensions=\"{}{}\" NumberType=\"{}\" Precision=\"{}\" Format=\"HDF\">"
      "spheres.h5:/{}</DataItem>",
      rows, width > 1 ? fmt::format(" {}", width) : "", type, precision, name);
}

/// Rows first .. first + rows - 1 of a growing dataset with `total` rows.
std::string selection(const std::string& name, std::uint64_t first, std::uint64_t rows,
                      std::uint64_t total, int width, const char* type) {
  const std::string corner = width > 1 ? fmt::format("{} 0 1 1 {} {}", first, rows, width)
                                       : fmt::format("{} 1 {}", first, rows);
  return fmt::format(
      "<DataItem ItemType=\"HyperSlab\" Dimensions=\"{0}{1}\"><DataItem Dimensions=\"3 {2}\" "
      "Format=\"XML\">{3}</DataItem>{4}</DataItem>",
      rows, width > 1 ? fmt::format(" {}", width) : "", width > 1 ? 2 : 1, corner,
      data_item(name, total, width, type, 8));
}

std::string attribute(const char* name, int width, const std::string& item) {
  return fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">{}</Attribute>\n",
                     name, width > 1 ? "Vector" : "Scalar", item);
}

}  // namespace

template <class Visitor>
void SphereWriter::columns(Rows& rows, Visitor&& visit) {
  visit("step", 0, rows.step);
  visit("time", 0, rows.time);
  visit("tag", 0, rows.tag);
  visit("position", 3, rows.position);
  visit("velocity", 3, rows.velocity);
  visit("angular_velocity", 3, rows.angular_velocity);
  visit("force", 3, rows.force);
  visit("torque", 3, rows.torque);
  visit("radius", 0, rows.radius);
}

SphereWriter::SphereWriter(const std::string& folder, MPI_Comm comm,
                           std::span<const SphereState> spheres, std::int64_t resume_after,
                           double seconds_between_batches)
    : folder_(folder),
      path_(folder + "/spheres.h5"),
      interval_(seconds_between_batches),
      last_flush_(MPI_Wtime()) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  writes_ = rank == 0;
  on_first_rank(comm, [&] {
    if (resume_after < 0 || !resume_or_set_aside(path_, [&] { resume_file(resume_after); }))
      create_file(spheres);
    write_xdmf();
  });
}

SphereWriter::~SphereWriter() {
  try {
    flush();
  } catch (const UserError& error) {
    fmt::print(stderr, "{}\n", error.what());
  }
}

void SphereWriter::create_file(std::span<const SphereState> spheres) {
  require_space(path_, metadata_room + spheres.size() * 5 * sizeof(double));
  Hdf5File file(temporary_name(path_), Hdf5File::Access::create, MPI_COMM_SELF);
  std::vector<std::int64_t> tag;
  std::vector<double> position, radius;
  for (const SphereState& sphere : spheres) {
    if (sphere.mobile) continue;
    tag.push_back(sphere.tag);
    push(position, sphere.position);
    radius.push_back(sphere.radius);
  }
  const std::uint64_t n = fixed_ = tag.size();
  file.make_group("fixed");
  file.write("fixed/tag", {{n}, {0}, {n}}, tag.data());
  file.write("fixed/position", {{n, 3}, {0, 0}, {n, 3}}, position.data());
  file.write("fixed/radius", {{n}, {0}, {n}}, radius.data());
  if (n > 0) {
    file.make_table<std::int64_t>("fixed/force_step", 0, rows_per_chunk);
    file.make_table<double>("fixed/force_time", 0, rows_per_chunk);
    file.make_table<double>("fixed/force", 3 * n, 1);
  }
  file.make_group("mobile");
  columns(rows_, [&]<class T>(const char* name, std::uint64_t width, std::vector<T>&) {
    file.make_table<T>(fmt::format("mobile/{}", name), width, rows_per_chunk);
  });
  file.close();
  mark_whole(path_);
}

void SphereWriter::resume_file(std::int64_t step) {
  total_rows_ = 0;
  samples_.clear();
  mark_unfinished(path_);
  Hdf5File file(temporary_name(path_), Hdf5File::Access::append, MPI_COMM_SELF);
  fixed_ = file.shape("fixed/tag")[0];
  resume_forces(file, step);
  const std::uint64_t stored = file.shape("mobile/step")[0];
  std::vector<std::int64_t> steps(stored);
  std::vector<double> times(stored);
  file.read("mobile/step", {{stored}, {0}, {stored}}, steps.data());
  file.read("mobile/time", {{stored}, {0}, {stored}}, times.data());
  total_rows_ = static_cast<std::uint64_t>(std::upper_bound(steps.begin(), steps.end(), step) -
                                           steps.begin());
  columns(rows_, [&]<class T>(const char* name, std::uint64_t, std::vector<T>&) {
    file.shorten(fmt::format("mobile/{}", name), total_rows_);
  });
  for (std::uint64_t row = 0; row < total_rows_; ++row) {
    if (row == 0 || steps[row] != steps[row - 1]) samples_.push_back({times[row], row, 0});
    ++samples_.back().rows;
  }
  file.close();
  mark_whole(path_);
}

void SphereWriter::resume_forces(Hdf5File& file, std::int64_t step) const {
  if (fixed_ == 0) return;
  const std::uint64_t stored = file.shape("fixed/force_step")[0];
  std::vector<std::int64_t> steps(stored);
  file.read("fixed/force_step", {{stored}, {0}, {stored}}, steps.data());
  const auto kept = static_cast<std::uint64_t>(std::upper_bound(steps.begin(), steps.end(), step) -
                                               steps.begin());
  for (const char* name : force_columns) file.shorten(name, kept);
}

void SphereWriter::sample_fixed(std::int64_t step, double time, std::span<const SphereLoad> forces,
                                bool replace) {
  if (!writes_ || fixed_ == 0) return;
  std::vector<double> row;
  for (const SphereLoad& force : forces) push(row, force.force);
  require_space(path_, metadata_room + row.size() * sizeof(double));
  mark_unfinished(path_);
  Hdf5File file(temporary_name(path_), Hdf5File::Access::append, MPI_COMM_SELF);
  if (replace)
    for (const char* name : force_columns) file.shorten(name, 0);
  file.append<std::int64_t>("fixed/force_step", std::span(&step, 1));
  file.append<double>("fixed/force_time", std::span(&time, 1));
  file.append<double>("fixed/force", row);
  file.close();
  mark_whole(path_);
}

void SphereWriter::sample(std::int64_t step, double time, std::span<const SphereState> spheres,
                          std::span<const SphereLoad> loads) {
  if (!writes_) return;
  std::unordered_map<std::int64_t, const SphereLoad*> load_of;
  for (const SphereLoad& load : loads) load_of[load.tag] = &load;
  const std::uint64_t first = total_rows_ + rows_.step.size();
  for (const SphereState& sphere : spheres) {
    if (!sphere.mobile) continue;
    const auto found = load_of.find(sphere.tag);
    const SphereLoad load = found == load_of.end() ? SphereLoad{} : *found->second;
    rows_.step.push_back(step);
    rows_.time.push_back(time);
    rows_.tag.push_back(sphere.tag);
    push(rows_.position, sphere.position);
    push(rows_.velocity, sphere.velocity);
    push(rows_.angular_velocity, sphere.angular_velocity);
    push(rows_.force, load.force);
    push(rows_.torque, load.torque);
    rows_.radius.push_back(sphere.radius);
  }
  const std::uint64_t rows = total_rows_ + rows_.step.size() - first;
  if (rows > 0) samples_.push_back({time, first, rows});
  if (MPI_Wtime() - last_flush_ >= interval_ || rows_.step.size() >= largest_batch) flush();
}

void SphereWriter::flush() {
  last_flush_ = MPI_Wtime();
  if (!writes_ || rows_.step.empty()) return;
  const std::uint64_t rows = rows_.step.size();
  require_space(path_, metadata_room + rows * (sizeof(rows) * 19));
  mark_unfinished(path_);
  Hdf5File file(temporary_name(path_), Hdf5File::Access::append, MPI_COMM_SELF);
  columns(rows_, [&]<class T>(const char* name, std::uint64_t, std::vector<T>& column) {
    file.append<T>(fmt::format("mobile/{}", name), column);
    column.clear();
  });
  file.close();
  mark_whole(path_);
  total_rows_ += rows;
  write_xdmf();
}

void SphereWriter::write_xdmf() const {
  std::string text = "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\">\n<Domain>\n";
  if (fixed_ > 0)
    text += fmt::format(
        "<Grid Name=\"fixed\" GridType=\"Uniform\">\n"
        "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\"/>\n"
        "<Geometry GeometryType=\"XYZ\">{}</Geometry>\n{}{}</Grid>\n",
        fixed_, data_item("fixed/position", fixed_, 3, "Float", 8),
        attribute("radius", 1, data_item("fixed/radius", fixed_, 1, "Float", 8)),
        attribute("tag", 1, data_item("fixed/tag", fixed_, 1, "Int", 8)));
  text += "<Grid Name=\"mobile\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  const std::size_t stride = samples_.size() / xdmf_samples + 1;
  for (std::size_t n = 0; n < samples_.size(); n += stride) {
    const Sample& s = samples_[n];
    if (s.first_row + s.rows > total_rows_) break;
    const auto column = [&](const char* name, int width, const char* type) {
      return selection(fmt::format("mobile/{}", name), s.first_row, s.rows, total_rows_, width,
                       type);
    };
    text += fmt::format(
        "<Grid Name=\"mobile\" GridType=\"Uniform\">\n<Time Value=\"{}\"/>\n"
        "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\"/>\n"
        "<Geometry GeometryType=\"XYZ\">{}</Geometry>\n",
        s.time, s.rows, column("position", 3, "Float"));
    text += attribute("tag", 1, column("tag", 1, "Int"));
    text += attribute("radius", 1, column("radius", 1, "Float"));
    for (const char* name : {"velocity", "angular_velocity", "force", "torque"})
      text += attribute(name, 3, column(name, 3, "Float"));
    text += "</Grid>\n";
  }
  text += "</Grid>\n</Domain>\n</Xdmf>\n";
  write_text_file(folder_ + "/spheres.xdmf", text);
}

}  // namespace bedload
