#include "fluid/output/sphere_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "fluid/files/atomic_file.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/files/hdf5_file.hpp"
#include "fluid/files/resumable_file.hpp"
#include "fluid/grid/mpi_ranks.hpp"

namespace bedload {
namespace {

constexpr std::uint64_t rows_per_chunk = 1024;
constexpr std::uint64_t metadata_room = 1 << 20;
constexpr std::size_t largest_batch = 100000;  // rows of a rank: about 17 MB
constexpr double patience = 1.0;               // for ranks that end by a mistake [s]
constexpr std::size_t xdmf_samples = 1000;     // ParaView's time slider; spheres.h5 holds all

/// The samples of forces on fixed spheres, a row each.
constexpr std::array force_columns{"fixed/force_step", "fixed/force_time", "fixed/force"};

void push(std::vector<double>& column, const Vec3& value) {
  column.insert(column.end(), value.data(), value.data() + 3);
}

/// The rows of the fixed, or mobile, spheres among `spheres` with what acts on them, and of loads
/// on spheres that other ranks have.
void push(std::vector<SphereRow>& rows, std::int64_t sample, bool mobile,
          std::span<const SphereState> spheres, std::span<const SphereLoad> loads) {
  std::unordered_map<std::int64_t, SphereLoad> load_of;
  for (const SphereLoad& load : loads) {
    SphereLoad& sum = load_of[load.tag];
    sum.force += load.force;
    sum.torque += load.torque;
  }
  for (const SphereState& sphere : spheres) {
    if (sphere.mobile != mobile) continue;
    const auto found = load_of.extract(sphere.tag);
    const SphereLoad load = found ? found.mapped() : SphereLoad{};
    rows.push_back({.sample = sample,
                    .tag = sphere.tag,
                    .position = sphere.position,
                    .velocity = sphere.velocity,
                    .angular_velocity = sphere.angular_velocity,
                    .force = load.force,
                    .torque = load.torque,
                    .radius = sphere.radius});
  }
  for (const auto& [tag, load] : load_of)
    rows.push_back({.sample = sample, .tag = tag, .force = load.force, .torque = load.torque});
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
void SphereWriter::columns(Columns& rows, Visitor&& visit) {
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
                           double seconds_between_batches, std::uint64_t few)
    : folder_(folder),
      path_(folder + "/spheres.h5"),
      interval_(seconds_between_batches),
      last_flush_(MPI_Wtime()),
      few_(few) {
  MPI_Comm_dup(comm, &comm_);
  is_first_ = rank_in(comm_) == 0;
  int is_new = 0;
  on_first_rank(comm_, [&] {
    if (resume_after >= 0 && resume_or_set_aside(path_, [&] { resume_file(resume_after); })) return;
    create_file();
    is_new = 1;
  });
  MPI_Bcast(&is_new, 1, MPI_INT, 0, comm_);
  if (is_new != 0) write_fixed(spheres);
  MPI_Bcast(&fixed_, 1, MPI_UINT64_T, 0, comm_);
  on_first_rank(comm_, [&] { write_xdmf(); });
}

// When a run ends by a mistake that all ranks have met, what they have gathered is written; one
// that has met it alone does not wait for the others.
SphereWriter::~SphereWriter() {
  if (!all_arrive(comm_, patience)) return;
  try {
    flush();
  } catch (const UserError& error) {
    if (is_first_) fmt::print(stderr, "{}\n", error.what());
  }
  MPI_Comm_free(&comm_);
}

void SphereWriter::create_file() {
  require_space(path_, metadata_room);
  Hdf5File file(temporary_name(path_), Hdf5File::Access::create, MPI_COMM_SELF);
  file.make_group("fixed");
  file.make_table<std::int64_t>("fixed/tag", 0, rows_per_chunk);
  file.make_table<double>("fixed/position", 3, rows_per_chunk);
  file.make_table<double>("fixed/radius", 0, rows_per_chunk);
  file.make_group("mobile");
  Columns none;
  columns(none, [&]<class T>(const char* name, std::uint64_t width, std::vector<T>&) {
    file.make_table<T>(fmt::format("mobile/{}", name), width, rows_per_chunk);
  });
  file.close();
  mark_whole(path_);
}

/// Each rank brings its own; the forces' table, as wide as they are many, is made with them.
void SphereWriter::write_fixed(std::span<const SphereState> spheres) {
  fixed_ = 0;
  for (const SphereState& sphere : spheres) fixed_ += sphere.mobile ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, &fixed_, 1, MPI_UINT64_T, MPI_SUM, comm_);
  if (fixed_ == 0) return;
  std::vector<SphereRow> rows;
  push(rows, 0, false, spheres, {});
  const Instant start{0, 0.0};
  const Columns mine = columns_of(ordered_by_tag(comm_, rows, 1, few_).mine, std::span(&start, 1));
  in_file(fixed_, 5 * sizeof(double), [&](Hdf5File& file) {
    file.append<std::int64_t>("fixed/tag", mine.tag);
    file.append<double>("fixed/position", mine.position);
    file.append<double>("fixed/radius", mine.radius);
    file.make_table<std::int64_t>("fixed/force_step", 0, rows_per_chunk);
    file.make_table<double>("fixed/force_time", 0, rows_per_chunk);
    file.make_table<double>("fixed/force", 3 * fixed_, 1);
  });
}

void SphereWriter::resume_file(std::int64_t step) {
  total_rows_ = 0;
  samples_.clear();
  mark_unfinished(path_);
  Hdf5File file(temporary_name(path_), Hdf5File::Access::append, MPI_COMM_SELF);
  fixed_ = file.shape("fixed/tag")[0];
  resume_forces(file, step);
  read_samples(file, step);
  Columns none;
  columns(none, [&]<class T>(const char* name, std::uint64_t, std::vector<T>&) {
    file.shorten(fmt::format("mobile/{}", name), total_rows_);
  });
  file.close();
  mark_whole(path_);
}

/// The samples up to `step`, a block of the table after the other.
void SphereWriter::read_samples(const Hdf5File& file, std::int64_t step) {
  const std::uint64_t stored = file.shape("mobile/step")[0];
  std::int64_t before = -1;
  for (std::uint64_t first = 0; first < stored; first += few_rows) {
    const std::uint64_t count = std::min(few_rows, stored - first);
    std::vector<std::int64_t> steps(count);
    std::vector<double> times(count);
    file.read("mobile/step", {{stored}, {first}, {count}}, steps.data());
    file.read("mobile/time", {{stored}, {first}, {count}}, times.data());
    for (std::uint64_t n = 0; n < count; ++n) {
      if (steps[n] > step) return;
      if (steps[n] != before) samples_.push_back({times[n], total_rows_, 0});
      before = steps[n];
      ++samples_.back().rows;
      ++total_rows_;
    }
  }
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

void SphereWriter::sample_fixed(std::int64_t step, double time,
                                std::span<const SphereState> spheres,
                                std::span<const SphereLoad> loads, bool replace) {
  if (fixed_ == 0) return;
  std::vector<SphereRow> rows;
  push(rows, 0, false, spheres, loads);
  const Instant now{step, time};
  const Columns mine = columns_of(ordered_by_tag(comm_, rows, 1, few_).mine, std::span(&now, 1));
  const std::size_t one = is_first_ ? 1 : 0;
  in_file(fixed_, 3 * sizeof(double), [&](Hdf5File& file) {
    if (replace)
      for (const char* name : force_columns) file.shorten(name, 0);
    file.append<std::int64_t>("fixed/force_step", std::span(&step, one));
    file.append<double>("fixed/force_time", std::span(&time, one));
    file.append_row<double>("fixed/force", mine.force);
  });
}

void SphereWriter::sample(std::int64_t step, double time, std::span<const SphereState> spheres,
                          std::span<const SphereLoad> loads) {
  const auto sample = static_cast<std::int64_t>(instants_.size());
  instants_.push_back({step, time});
  push(rows_, sample, true, spheres, loads);
  int is_due = MPI_Wtime() - last_flush_ >= interval_ || rows_.size() >= largest_batch ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &is_due, 1, MPI_INT, MPI_MAX, comm_);
  if (is_due != 0) flush();
}

void SphereWriter::flush() {
  last_flush_ = MPI_Wtime();
  // Both are empty from here on: what could not be written is not tried again.
  const std::vector<Instant> instants = std::exchange(instants_, {});
  const std::vector<SphereRow> gathered = std::exchange(rows_, {});
  if (instants.empty()) return;
  const SphereRows ordered = ordered_by_tag(comm_, gathered, instants.size(), few_);
  const auto rows =
      std::accumulate(ordered.of_sample.begin(), ordered.of_sample.end(), std::uint64_t{0});
  if (rows == 0) return;
  Columns mine = columns_of(ordered.mine, instants);
  in_file(rows, static_cast<std::uint64_t>(row_bytes), [&](Hdf5File& file) {
    columns(mine, [&]<class T>(const char* name, std::uint64_t, std::vector<T>& column) {
      file.append<T>(fmt::format("mobile/{}", name), column);
    });
  });
  on_first_rank(comm_, [&] {
    note_samples(instants, ordered.of_sample);
    write_xdmf();
  });
}

/// Lets write(file) add `rows` rows of `bytes` each, in their order on the ranks as
/// ordered_by_tag() leaves them: on the first rank where they are few, else on all together.
template <class Write>
void SphereWriter::in_file(std::uint64_t rows, std::uint64_t bytes, Write&& write) {
  const auto open_and_write = [&](MPI_Comm writers) {
    Hdf5File file(temporary_name(path_), Hdf5File::Access::append, writers);
    write(file);
    file.close();
  };
  on_first_rank(comm_, [&] {
    require_space(path_, metadata_room + rows * bytes);
    mark_unfinished(path_);
    if (rows <= few_) open_and_write(MPI_COMM_SELF);
  });
  if (rows > few_) open_and_write(comm_);
  on_first_rank(comm_, [&] { mark_whole(path_); });
}

SphereWriter::Columns SphereWriter::columns_of(std::span<const SphereRow> rows,
                                               std::span<const Instant> instants) {
  Columns table;
  for (const SphereRow& row : rows) {
    const Instant& instant = instants[static_cast<std::size_t>(row.sample)];
    table.step.push_back(instant.step);
    table.time.push_back(instant.time);
    table.tag.push_back(row.tag);
    push(table.position, row.position);
    push(table.velocity, row.velocity);
    push(table.angular_velocity, row.angular_velocity);
    push(table.force, row.force);
    push(table.torque, row.torque);
    table.radius.push_back(row.radius);
  }
  return table;
}

void SphereWriter::note_samples(std::span<const Instant> instants,
                                std::span<const std::uint64_t> rows) {
  for (std::size_t n = 0; n < instants.size(); ++n) {
    if (rows[n] > 0) samples_.push_back({instants[n].time, total_rows_, rows[n]});
    total_rows_ += rows[n];
  }
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
