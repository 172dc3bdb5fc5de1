#include "fluid/checkpoint/group.hpp"

#include <fmt/format.h>

#include <utility>

#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

/// Header of a dataset, and its entry in the group.
constexpr std::uint64_t dataset_room = 1024;

}  // namespace

SaveGroup::SaveGroup(Hdf5File* file, std::string path, MPI_Comm comm, std::uint64_t& bytes)
    : file_(file), path_(std::move(path)), comm_(comm), bytes_(&bytes) {
  *bytes_ += dataset_room;
  if (file_) file_->make_group(path_);
}

SaveGroup SaveGroup::group(const std::string& name) const {
  return {file_, path_ + "/" + name, comm_, *bytes_};
}

void SaveGroup::text(const std::string& name, const std::string& words) const {
  *bytes_ += dataset_room + words.size();
  if (file_) file_->write_text(path_ + "/" + name, words);
}

void SaveGroup::parts(const std::string& name, std::uint64_t mine) const {
  const auto rows_here = static_cast<std::int64_t>(mine);
  rows<std::int64_t>(name, std::span<const std::int64_t>(&rows_here, 1));
}

bool SaveGroup::is_first() const {
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  return rank == 0;
}

Hyperslab SaveGroup::place_of(std::uint64_t rows, std::uint64_t width) const {
  std::uint64_t before = 0, all = 0;
  MPI_Exscan(&rows, &before, 1, MPI_UINT64_T, MPI_SUM, comm_);
  if (is_first()) before = 0;  // MPI leaves it open there
  MPI_Allreduce(&rows, &all, 1, MPI_UINT64_T, MPI_SUM, comm_);
  if (width == 1) return {{all}, {before}, {rows}};
  return {{all, width}, {before, 0}, {rows, width}};
}

void SaveGroup::count(const Hyperslab& block, std::size_t size) const {
  std::uint64_t numbers = 1;
  for (const std::uint64_t n : block.shape) numbers *= n;
  *bytes_ += dataset_room + numbers * size;
}

std::string LoadGroup::text(const std::string& name) const {
  return file_->read_text(path_ + "/" + name);
}

std::uint64_t LoadGroup::size(const std::string& name) const {
  const std::vector<std::uint64_t> shape = file_->shape(path_ + "/" + name);
  if (shape.empty()) throw UserError(fmt::format("{}/{}: does not hold a list.", path_, name));
  return shape[0];
}

Part LoadGroup::part_of_rank(const std::string& parts, int rank) const {
  const auto rows_of = list<std::int64_t>(parts);
  Part part;
  for (std::size_t r = 0; r < rows_of.size(); ++r) {
    part.count = static_cast<std::uint64_t>(rows_of[r]);
    if (r == static_cast<std::size_t>(rank)) return part;
    part.first += part.count;
  }
  throw UserError(fmt::format("{}/{}: has no part of rank {}.", path_, parts, rank));
}

Hyperslab LoadGroup::block_of(const std::string& name, const Part& part,
                              std::uint64_t width) const {
  const std::uint64_t all = size(name);
  if (part.first + part.count > all)
    throw UserError(
        fmt::format("{}/{}: does not hold {} rows.", path_, name, part.first + part.count));
  if (width == 1) return {{all}, {part.first}, {part.count}};
  return {{all, width}, {part.first, 0}, {part.count, width}};
}

Part even_share(std::uint64_t rows, MPI_Comm comm) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  const auto r = static_cast<std::uint64_t>(rank), n = static_cast<std::uint64_t>(ranks);
  const std::uint64_t first = rows * r / n;
  return {first, rows * (r + 1) / n - first};
}

}  // namespace bedload
