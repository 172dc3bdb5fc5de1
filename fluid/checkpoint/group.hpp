#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fluid/files/hdf5_file.hpp"

namespace bedload {

/// One group of a checkpoint that is being written: named datasets of one type each. An object that
/// has a state offers
///
///   void save(SaveGroup group) const;
///   void load(const LoadGroup& group);
///
/// and what one writes the other reads by the same names. Collective over the file's ranks.
class SaveGroup {
 public:
  /// `file` nullptr: nothing is written, only the size is added up.
  SaveGroup(Hdf5File* file, std::string path, MPI_Comm comm, std::uint64_t& bytes);

  /// A group below this one.
  SaveGroup group(const std::string& name) const;

  /// One number, the first rank's.
  template <class T>
  void value(const std::string& name, const T& number) const {
    list<T>(name, std::span<const T>(&number, 1));
  }
  /// A text, the first rank's.
  void text(const std::string& name, const std::string& words) const;
  /// A list, the first rank's; it has the same length on each.
  template <class T>
  void list(const std::string& name, std::span<const T> numbers) const {
    rows<T>(name, is_first() ? numbers : numbers.first(0));
  }
  /// A table of `width` numbers a row (1: a list): each rank's rows behind those of the ranks
  /// before.
  template <class T>
  void rows(const std::string& name, std::span<const T> mine, std::uint64_t width = 1) const {
    const Hyperslab block = place_of(mine.size() / width, width);
    count(block, sizeof(T));
    if (file_) file_->write(path_ + "/" + name, block, mine.data());
  }
  /// How many rows each rank has, to be found again by LoadGroup::part_of_rank().
  void parts(const std::string& name, std::uint64_t mine) const;

  MPI_Comm comm() const { return comm_; }

 private:
  bool is_first() const;
  Hyperslab place_of(std::uint64_t rows, std::uint64_t width) const;
  void count(const Hyperslab& block, std::size_t size) const;

  Hdf5File* file_;
  std::string path_;
  MPI_Comm comm_;
  std::uint64_t* bytes_;
};

/// Rows first .. first + count - 1 of a table.
struct Part {
  std::uint64_t first = 0, count = 0;
};

/// The same group when it is read. Each rank for itself: every member throws UserError on that rank
/// alone (collectively() spreads it).
class LoadGroup {
 public:
  LoadGroup(const Hdf5File& file, std::string path) : file_(&file), path_(std::move(path)) {}

  LoadGroup group(const std::string& name) const { return {*file_, path_ + "/" + name}; }
  bool has(const std::string& name) const { return file_->has(path_ + "/" + name); }

  template <class T>
  T value(const std::string& name) const {
    return rows<T>(name, {0, 1}, 1).front();
  }
  std::string text(const std::string& name) const;
  template <class T>
  std::vector<T> list(const std::string& name) const {
    return rows<T>(name, {0, size(name)}, 1);
  }
  template <class T>
  std::vector<T> rows(const std::string& name, const Part& part, std::uint64_t width) const {
    std::vector<T> numbers(part.count * width);
    file_->read(path_ + "/" + name, block_of(name, part, width), numbers.data());
    return numbers;
  }
  /// Rows of a table, or length of a list.
  std::uint64_t size(const std::string& name) const;
  /// The rows that `rank` wrote, as SaveGroup::parts() noted them under the name `parts`.
  Part part_of_rank(const std::string& parts, int rank) const;

 private:
  Hyperslab block_of(const std::string& name, const Part& part, std::uint64_t width) const;

  const Hdf5File* file_;
  std::string path_;
};

/// The rank's even share of `rows`.
Part even_share(std::uint64_t rows, MPI_Comm comm);

}  // namespace bedload
