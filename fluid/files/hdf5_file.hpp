#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace bedload {

/// The block of a global array that one rank writes or reads, slowest index first.
struct Hyperslab {
  std::vector<std::uint64_t> shape;  ///< of the whole array
  std::vector<std::uint64_t> start;  ///< first element of the block
  std::vector<std::uint64_t> count;  ///< extent of the block; 0 for a rank without a share

  std::uint64_t size() const {
    std::uint64_t product = 1;
    for (const std::uint64_t n : count) product *= n;
    return product;
  }
};

/// How a dataset lies in the file: contiguous (no chunk), or in chunks, shuffled and deflated when
/// `gzip` > 0.
struct Storage {
  std::vector<std::uint64_t> chunk;
  int gzip = 0;
};

enum class NumberType { uint8, int16, int32, int64, float32, float64 };
template <class T>
inline constexpr NumberType number_type = NumberType::float64;
template <>
inline constexpr NumberType number_type<std::uint8_t> = NumberType::uint8;
template <>
inline constexpr NumberType number_type<std::int16_t> = NumberType::int16;
template <>
inline constexpr NumberType number_type<std::int32_t> = NumberType::int32;
template <>
inline constexpr NumberType number_type<std::int64_t> = NumberType::int64;
template <>
inline constexpr NumberType number_type<float> = NumberType::float32;

/// An HDF5 file that the ranks of one communicator write or read together. A thin shell over the C
/// interface: identifiers are closed, every return code is checked, and each failure is a UserError
/// of one sentence with the file's name, thrown on all ranks alike by the collective calls.
///
/// One rank alone uses HDF5's POSIX driver, several the MPI-IO driver. Files are not locked: a
/// person may look at the output of a run in progress.
class Hdf5File {
 public:
  enum class Access { create, append, read };

  /// Collective. `create` replaces what stands under `path`; `user_block` bytes (0 or a power of
  /// two from 512) are left free in front of the HDF5 content.
  Hdf5File(const std::string& path, Access access, MPI_Comm comm, std::uint64_t user_block = 0);
  /// Closes if close() was not reached. After a failed operation the file is left alone instead:
  /// closing it would write again, and was seen to hang.
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  /// Flushes and closes. Collective.
  void close();

  bool has(const std::string& name) const;
  std::vector<std::string> names(const std::string& group) const;
  std::vector<std::uint64_t> shape(const std::string& dataset) const;
  NumberType type(const std::string& dataset) const;

  void make_group(const std::string& name);  ///< Collective.
  void remove(const std::string& name);      ///< Collective.

  /// Creates a dataset of T and writes every rank's block at once. Collective.
  template <class T>
  void write(const std::string& dataset, const Hyperslab& block, const T* values,
             const Storage& storage = {}) {
    create_dataset(dataset, block.shape, number_type<T>, storage);
    write_block(dataset, block, number_type<T>, values);
  }
  /// The same without a copy of the whole block: fill(first, count, values) puts the block's
  /// elements first .. first + count - 1 of the slowest index into a buffer of some `bytes`.
  /// Collective.
  template <class T, class Fill>
  void write_in_pieces(const std::string& dataset, const Hyperslab& block, Fill fill,
                       std::size_t bytes = std::size_t{1} << 20) {
    create_dataset(dataset, block.shape, number_type<T>, {});
    const std::uint64_t pieces = most_on_any_rank((block.size() * sizeof(T) + bytes - 1) / bytes);
    const std::uint64_t all = block.count[0];
    Hyperslab piece = block;
    if (pieces > 0) piece.count[0] = (all + pieces - 1) / pieces;
    std::vector<T> values(piece.size());
    for (std::uint64_t n = 0; n < pieces; ++n) {
      const std::uint64_t first = all * n / pieces, count = all * (n + 1) / pieces - first;
      piece.start[0] = block.start[0] + first;
      piece.count[0] = count;
      fill(static_cast<int>(first), static_cast<int>(count), values.data());
      write_block(dataset, piece, number_type<T>, values.data());
    }
  }
  /// Reads one block, converted to T. Each rank for itself; throws on that rank alone (wrap a
  /// series of reads in collectively()).
  template <class T>
  void read(const std::string& dataset, const Hyperslab& block, T* values) const {
    read_block(dataset, block, number_type<T>, values);
  }

  /// A dataset that is one text, the first rank's. Collective.
  void write_text(const std::string& dataset, const std::string& text);
  /// Each rank for itself, as read().
  std::string read_text(const std::string& dataset) const;

  /// An empty table of `width` numbers per row that grows (width 0: a plain list). Collective.
  template <class T>
  void make_table(const std::string& dataset, std::uint64_t width, std::uint64_t rows_per_chunk) {
    make_growing(dataset, number_type<T>, width, rows_per_chunk);
  }
  /// Adds rows behind the last, each rank's behind those of the ranks before it. Collective.
  template <class T>
  void append(const std::string& dataset, std::span<const T> rows) {
    append_rows(dataset, number_type<T>, rows.data(), rows.size());
  }
  /// Adds one row to a table, each rank's part of it behind those of the ranks before. Collective.
  template <class T>
  void append_row(const std::string& dataset, std::span<const T> part) {
    append_one_row(dataset, number_type<T>, part.data(), part.size());
  }
  /// Cuts a table down to its first rows. Collective.
  void shorten(const std::string& dataset, std::uint64_t rows);

  /// Attributes are the same on every rank. "/" is the file itself. Collective.
  template <class T>
  void set_attribute(const std::string& object, const std::string& name,
                     std::span<const T> values) {
    write_attribute(object, name, number_type<T>, values.data(), values.size());
  }
  template <class T>
  void set_attribute(const std::string& object, const std::string& name, const T& value) {
    set_attribute<T>(object, name, std::span<const T>(&value, 1));
  }
  void set_text(const std::string& object, const std::string& name, const std::string& text);
  template <class T>
  std::vector<T> attribute(const std::string& object, const std::string& name,
                           std::size_t count) const {
    std::vector<T> values(count);
    read_attribute(object, name, number_type<T>, values.data(), count);
    return values;
  }
  template <class T>
  T attribute(const std::string& object, const std::string& name) const {
    return attribute<T>(object, name, 1)[0];
  }

 private:
  template <class Work>
  void collective(Work&& work);
  std::uint64_t most_on_any_rank(std::uint64_t here) const;
  void create_dataset(const std::string& dataset, const std::vector<std::uint64_t>& shape,
                      NumberType type, const Storage& storage);
  void write_block(const std::string& dataset, const Hyperslab& block, NumberType type,
                   const void* values);
  void read_block(const std::string& dataset, const Hyperslab& block, NumberType type,
                  void* values) const;
  void make_growing(const std::string& dataset, NumberType type, std::uint64_t width,
                    std::uint64_t rows_per_chunk);
  void append_rows(const std::string& dataset, NumberType type, const void* values,
                   std::uint64_t numbers);
  void append_one_row(const std::string& dataset, NumberType type, const void* values,
                      std::uint64_t numbers);
  void set_extent(const std::string& dataset, const std::vector<std::uint64_t>& shape);
  struct AmongRanks {
    std::uint64_t before, all;
  };
  AmongRanks among_ranks(std::uint64_t here) const;
  void write_attribute(const std::string& object, const std::string& name, NumberType type,
                       const void* values, std::size_t count);
  void read_attribute(const std::string& object, const std::string& name, NumberType type,
                      void* values, std::size_t count) const;

  std::string path_;
  MPI_Comm comm_;
  bool parallel_ = false;  ///< several ranks: MPI-IO
  bool broken_ = false;    ///< an operation failed
  std::int64_t file_ = -1;
};

}  // namespace bedload
