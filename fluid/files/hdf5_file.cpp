#include "fluid/files/hdf5_file.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <array>
#include <cstdlib>
#include <string_view>
#include <type_traits>

#include "fluid/files/collectively.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

static_assert(std::is_same_v<hid_t, std::int64_t>, "HDF5 1.10 or later");

/// Why HDF5 failed: the operating system's words where the error stack has them, otherwise its
/// innermost description.
std::string reason() {
  std::string text;
  const auto look = [](unsigned, const H5E_error2_t* error, void* found) -> herr_t {
    auto& words = *static_cast<std::string*>(found);
    const std::string_view description = error->desc ? error->desc : "";
    constexpr std::string_view mark = "error message = '";
    if (const auto at = description.find(mark); at != std::string_view::npos) {
      const auto begin = at + mark.size();
      words = description.substr(begin, description.find('\'', begin) - begin);
      return 1;
    }
    if (words.empty()) words = description;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, look, &text);
  return text.empty() ? "HDF5 gives no reason" : text;
}

/// HDF5 answers every failure with a negative number. `file`: its path, `verb`: what cannot be
/// done.
template <class Code>
Code checked(Code code, const std::string& file, const char* verb) {
  if (code < 0) throw UserError(fmt::format("{}: cannot be {} ({}).", file, verb, reason()));
  return code;
}

/// Closes an HDF5 identifier at the end of its scope.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

hid_t native(NumberType type) {
  switch (type) {
    case NumberType::uint8:
      return H5T_NATIVE_UINT8;
    case NumberType::int16:
      return H5T_NATIVE_INT16;
    case NumberType::int32:
      return H5T_NATIVE_INT32;
    case NumberType::int64:
      return H5T_NATIVE_INT64;
    case NumberType::float32:
      return H5T_NATIVE_FLOAT;
    case NumberType::float64:
      return H5T_NATIVE_DOUBLE;
  }
  std::abort();
}

std::vector<hsize_t> sizes(const std::vector<std::uint64_t>& values) {
  return {values.begin(), values.end()};
}

constexpr const char* written = "written";
constexpr const char* read_from = "read";

}  // namespace

/// Runs a collective operation; a failure on one rank becomes a failure on all.
template <class Work>
void Hdf5File::collective(Work&& work) {
  try {
    if (parallel_)
      collectively(comm_, work);
    else
      work();
  } catch (const UserError&) {
    broken_ = true;
    throw;
  }
}

Hdf5File::Hdf5File(const std::string& path, Access access, MPI_Comm comm, std::uint64_t user_block)
    : path_(path), comm_(comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  parallel_ = ranks > 1;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // failures become UserError, not printed stacks
  const char* verb = access == Access::read ? read_from : written;
  collective([&] {
    const Handle driver(checked(H5Pcreate(H5P_FILE_ACCESS), path_, verb), H5Pclose);
    if (parallel_) {
      checked(H5Pset_fapl_mpio(driver, comm_, MPI_INFO_NULL), path_, verb);
      // Metadata go through one rank's reads and one aggregated write instead of one per rank.
      if (access != Access::read) {
        checked(H5Pset_all_coll_metadata_ops(driver, true), path_, verb);
        checked(H5Pset_coll_metadata_write(driver, true), path_, verb);
      }
    } else {
      checked(H5Pset_file_locking(driver, false, true), path_, verb);
    }
    if (access == Access::create) {
      const Handle layout(checked(H5Pcreate(H5P_FILE_CREATE), path_, verb), H5Pclose);
      checked(H5Pset_userblock(layout, user_block), path_, verb);
      file_ = checked(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, layout, driver), path_, verb);
    } else {
      const unsigned mode = access == Access::read ? H5F_ACC_RDONLY : H5F_ACC_RDWR;
      file_ = checked(H5Fopen(path_.c_str(), mode, driver), path_, verb);
    }
  });
}

Hdf5File::~Hdf5File() {
  if (file_ >= 0 && !broken_) H5Fclose(file_);
}

void Hdf5File::close() {
  collective([&] { checked(H5Fflush(file_, H5F_SCOPE_LOCAL), path_, written); });
  collective([&] { checked(H5Fclose(file_), path_, written); });
  file_ = -1;
}

bool Hdf5File::has(const std::string& name) const {
  return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5File::names(const std::string& group) const {
  const Handle opened(
      checked(H5Gopen2(file_, group.c_str(), H5P_DEFAULT), path_ + ":" + group, read_from),
      H5Gclose);
  H5G_info_t info{};
  checked(H5Gget_info(opened, &info), path_, read_from);
  std::vector<std::string> list;
  for (hsize_t n = 0; n < info.nlinks; ++n) {
    const auto length = checked(
        H5Lget_name_by_idx(opened, ".", H5_INDEX_NAME, H5_ITER_INC, n, nullptr, 0, H5P_DEFAULT),
        path_, read_from);
    std::string name(static_cast<std::size_t>(length), '\0');
    checked(H5Lget_name_by_idx(opened, ".", H5_INDEX_NAME, H5_ITER_INC, n, name.data(),
                               name.size() + 1, H5P_DEFAULT),
            path_, read_from);
    list.push_back(name);
  }
  return list;
}

std::vector<std::uint64_t> Hdf5File::shape(const std::string& dataset) const {
  const std::string place = path_ + ":" + dataset;
  const Handle data(checked(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), place, read_from),
                    H5Dclose);
  const Handle space(checked(H5Dget_space(data), place, read_from), H5Sclose);
  std::array<hsize_t, H5S_MAX_RANK> extent{};
  const int rank =
      checked(H5Sget_simple_extent_dims(space, extent.data(), nullptr), place, read_from);
  return {extent.begin(), extent.begin() + rank};
}

NumberType Hdf5File::type(const std::string& dataset) const {
  const std::string place = path_ + ":" + dataset;
  const Handle data(checked(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), place, read_from),
                    H5Dclose);
  const Handle stored(checked(H5Dget_type(data), place, read_from), H5Tclose);
  for (const NumberType candidate : {NumberType::uint8, NumberType::int16, NumberType::int32,
                                     NumberType::int64, NumberType::float32, NumberType::float64})
    if (H5Tequal(stored, native(candidate)) > 0) return candidate;
  throw UserError(fmt::format("{}: holds numbers of an unexpected type.", place));
}

void Hdf5File::make_group(const std::string& name) {
  collective([&] {
    const Handle group(
        checked(H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                path_ + ":" + name, written),
        H5Gclose);
  });
}

void Hdf5File::remove(const std::string& name) {
  collective(
      [&] { checked(H5Ldelete(file_, name.c_str(), H5P_DEFAULT), path_ + ":" + name, written); });
}

std::uint64_t Hdf5File::most_on_any_rank(std::uint64_t here) const {
  std::uint64_t most = here;
  if (parallel_) MPI_Allreduce(&here, &most, 1, MPI_UINT64_T, MPI_MAX, comm_);
  return most;
}

void Hdf5File::create_dataset(const std::string& dataset, const std::vector<std::uint64_t>& shape,
                              NumberType type, const Storage& storage) {
  const std::string place = path_ + ":" + dataset;
  collective([&] {
    const int rank = static_cast<int>(shape.size());
    const Handle layout(checked(H5Pcreate(H5P_DATASET_CREATE), place, written), H5Pclose);
    // Every byte is written by a rank: filling first would write all of it twice.
    checked(H5Pset_fill_time(layout, H5D_FILL_TIME_NEVER), place, written);
    if (!storage.chunk.empty()) {
      checked(H5Pset_chunk(layout, rank, sizes(storage.chunk).data()), place, written);
      if (storage.gzip > 0) {
        checked(H5Pset_shuffle(layout), place, written);
        checked(H5Pset_deflate(layout, static_cast<unsigned>(storage.gzip)), place, written);
      }
    }
    const Handle whole(
        checked(H5Screate_simple(rank, sizes(shape).data(), nullptr), place, written), H5Sclose);
    const Handle data(checked(H5Dcreate2(file_, dataset.c_str(), native(type), whole, H5P_DEFAULT,
                                         layout, H5P_DEFAULT),
                              place, written),
                      H5Dclose);
  });
}

void Hdf5File::write_block(const std::string& dataset, const Hyperslab& block, NumberType type,
                           const void* values) {
  const std::string place = path_ + ":" + dataset;
  collective([&] {
    const auto start = sizes(block.start), count = sizes(block.count);
    const Handle data(checked(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), place, written),
                      H5Dclose);
    const Handle whole(checked(H5Dget_space(data), place, written), H5Sclose);
    const Handle part(
        checked(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), place,
                written),
        H5Sclose);
    if (block.size() > 0) {
      checked(
          H5Sselect_hyperslab(whole, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
          place, written);
    } else {
      checked(H5Sselect_none(whole), place, written);
      checked(H5Sselect_none(part), place, written);
    }
    const Handle transfer(checked(H5Pcreate(H5P_DATASET_XFER), place, written), H5Pclose);
    if (parallel_) checked(H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE), place, written);
    checked(H5Dwrite(data, native(type), part, whole, transfer, values), place, written);
  });
}

void Hdf5File::read_block(const std::string& dataset, const Hyperslab& block, NumberType type,
                          void* values) const {
  if (block.size() == 0) return;
  const std::string place = path_ + ":" + dataset;
  const Handle data(checked(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), place, read_from),
                    H5Dclose);
  const Handle whole(checked(H5Dget_space(data), place, read_from), H5Sclose);
  if (shape(dataset) != block.shape)
    throw UserError(fmt::format("{}: does not have the expected shape.", place));
  const auto start = sizes(block.start), count = sizes(block.count);
  const Handle part(checked(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                            place, read_from),
                    H5Sclose);
  checked(H5Sselect_hyperslab(whole, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
          place, read_from);
  checked(H5Dread(data, native(type), part, whole, H5P_DEFAULT, values), place, read_from);
}

void Hdf5File::write_text(const std::string& dataset, const std::string& text) {
  const std::string place = path_ + ":" + dataset;
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  std::uint64_t size = text.size() + 1;
  if (parallel_) MPI_Bcast(&size, 1, MPI_UINT64_T, 0, comm_);
  collective([&] {
    const Handle type(checked(H5Tcopy(H5T_C_S1), place, written), H5Tclose);
    checked(H5Tset_size(type, size), place, written);
    checked(H5Tset_cset(type, H5T_CSET_UTF8), place, written);
    const Handle space(checked(H5Screate(H5S_SCALAR), place, written), H5Sclose);
    const Handle part(checked(H5Screate(H5S_SCALAR), place, written), H5Sclose);
    const Handle data(checked(H5Dcreate2(file_, dataset.c_str(), type, space, H5P_DEFAULT,
                                         H5P_DEFAULT, H5P_DEFAULT),
                              place, written),
                      H5Dclose);
    if (rank != 0) {
      checked(H5Sselect_none(space), place, written);
      checked(H5Sselect_none(part), place, written);
    }
    const Handle transfer(checked(H5Pcreate(H5P_DATASET_XFER), place, written), H5Pclose);
    if (parallel_) checked(H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE), place, written);
    checked(H5Dwrite(data, type, part, space, transfer, text.c_str()), place, written);
  });
}

std::string Hdf5File::read_text(const std::string& dataset) const {
  const std::string place = path_ + ":" + dataset;
  const Handle data(checked(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), place, read_from),
                    H5Dclose);
  const Handle type(checked(H5Dget_type(data), place, read_from), H5Tclose);
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0)
    throw UserError(fmt::format("{}: does not hold a text.", place));
  std::string text(H5Tget_size(type), '\0');
  checked(H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()), place, read_from);
  return text.substr(0, text.find('\0'));
}

void Hdf5File::make_growing(const std::string& dataset, NumberType type, std::uint64_t width,
                            std::uint64_t rows_per_chunk) {
  const std::string place = path_ + ":" + dataset;
  collective([&] {
    const int rank = width == 0 ? 1 : 2;
    const std::array<hsize_t, 2> empty{0, width}, limit{H5S_UNLIMITED, width},
        chunk{rows_per_chunk, width};
    const Handle layout(checked(H5Pcreate(H5P_DATASET_CREATE), place, written), H5Pclose);
    checked(H5Pset_chunk(layout, rank, chunk.data()), place, written);
    // Ranks that write together, perhaps a file that one of them has made, find every chunk there.
    checked(H5Pset_alloc_time(layout, H5D_ALLOC_TIME_EARLY), place, written);
    checked(H5Pset_fill_time(layout, H5D_FILL_TIME_NEVER), place, written);
    const Handle space(checked(H5Screate_simple(rank, empty.data(), limit.data()), place, written),
                       H5Sclose);
    const Handle data(checked(H5Dcreate2(file_, dataset.c_str(), native(type), space, H5P_DEFAULT,
                                         layout, H5P_DEFAULT),
                              place, written),
                      H5Dclose);
  });
}

/// How many things the ranks before this one have, and all together.
Hdf5File::AmongRanks Hdf5File::among_ranks(std::uint64_t here) const {
  AmongRanks found{0, here};
  if (!parallel_) return found;
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  MPI_Exscan(&here, &found.before, 1, MPI_UINT64_T, MPI_SUM, comm_);
  if (rank == 0) found.before = 0;  // MPI leaves it open there
  MPI_Allreduce(&here, &found.all, 1, MPI_UINT64_T, MPI_SUM, comm_);
  return found;
}

void Hdf5File::append_rows(const std::string& dataset, NumberType type, const void* values,
                           std::uint64_t numbers) {
  const AmongRanks rows = among_ranks(numbers);
  if (rows.all == 0) return;
  Hyperslab block;
  collective([&] {
    block.shape = shape(dataset);
    const std::uint64_t width = block.shape.size() == 2 ? block.shape[1] : 1;
    block.start.assign(block.shape.size(), 0);
    block.count = block.shape;
    block.start[0] = block.shape[0] + rows.before / width;
    block.count[0] = numbers / width;
    block.shape[0] += rows.all / width;
    set_extent(dataset, block.shape);
  });
  write_block(dataset, block, type, values);
}

void Hdf5File::append_one_row(const std::string& dataset, NumberType type, const void* values,
                              std::uint64_t numbers) {
  Hyperslab block{{}, {0, among_ranks(numbers).before}, {1, numbers}};
  collective([&] {
    block.shape = shape(dataset);
    block.start[0] = block.shape[0]++;
    set_extent(dataset, block.shape);
  });
  write_block(dataset, block, type, values);
}

void Hdf5File::shorten(const std::string& dataset, std::uint64_t rows) {
  collective([&] {
    std::vector<std::uint64_t> extent = shape(dataset);
    extent[0] = rows;
    set_extent(dataset, extent);
  });
}

void Hdf5File::set_extent(const std::string& dataset, const std::vector<std::uint64_t>& shape) {
  const std::string place = path_ + ":" + dataset;
  const Handle data(checked(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), place, written),
                    H5Dclose);
  checked(H5Dset_extent(data, sizes(shape).data()), place, written);
}

void Hdf5File::write_attribute(const std::string& object, const std::string& name, NumberType type,
                               const void* values, std::size_t count) {
  const std::string place = path_ + ":" + object;
  collective([&] {
    const hsize_t extent = count;
    const Handle space(count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &extent, nullptr),
                       H5Sclose);
    checked(hid_t{space}, place, written);
    const Handle attribute(
        checked(H5Acreate_by_name(file_, object.c_str(), name.c_str(), native(type), space,
                                  H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                place, written),
        H5Aclose);
    checked(H5Awrite(attribute, native(type), values), place, written);
  });
}

void Hdf5File::set_text(const std::string& object, const std::string& name,
                        const std::string& text) {
  const std::string place = path_ + ":" + object;
  collective([&] {
    const Handle type(checked(H5Tcopy(H5T_C_S1), place, written), H5Tclose);
    checked(H5Tset_size(type, text.size() + 1), place, written);
    checked(H5Tset_cset(type, H5T_CSET_UTF8), place, written);
    const Handle space(checked(H5Screate(H5S_SCALAR), place, written), H5Sclose);
    const Handle attribute(checked(H5Acreate_by_name(file_, object.c_str(), name.c_str(), type,
                                                     space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                                   place, written),
                           H5Aclose);
    checked(H5Awrite(attribute, type, text.c_str()), place, written);
  });
}

void Hdf5File::read_attribute(const std::string& object, const std::string& name, NumberType type,
                              void* values, std::size_t count) const {
  const std::string place = fmt::format("{}:{}@{}", path_, object, name);
  const Handle attribute(
      checked(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), place,
              read_from),
      H5Aclose);
  const Handle space(checked(H5Aget_space(attribute), place, read_from), H5Sclose);
  if (checked(H5Sget_simple_extent_npoints(space), place, read_from) !=
      static_cast<hssize_t>(count))
    throw UserError(fmt::format("{}: does not hold {} numbers.", place, count));
  checked(H5Aread(attribute, native(type), values), place, read_from);
}

}  // namespace bedload
