#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "fluid/checkpoint/group.hpp"
#include "fluid/files/hdf5_file.hpp"
#include "fluid/grid/field_list.hpp"
#include "fluid/grid/grid.hpp"

namespace bedload {

/// Where a stored flow stands, and on which grid it lives.
struct StateHeader {
  std::array<int, 3> cells{};
  std::array<double, 3> length{};              ///< [L]
  std::array<std::array<Wall, 2>, 3> walls{};  ///< as Grid::walls
  std::vector<double> y_faces{};               ///< as Grid::y_faces: empty on uniform y [L]
  double time = 0.0;                           ///< [T]
  std::int64_t step = 0;
  double driving = 0.0;  ///< mean driving force per volume along x [M/(L^2 T^2)]
};

/// Writes what a run needs beside the flow to go on: the group "run" of a state.
using SaveRun = std::function<void(const SaveGroup&)>;
inline constexpr const char* run_group = "run";

/// Of the block in front of the HDF5 content (file_header.hpp).
inline constexpr int state_format_version = 1;

/// Creates temporary_name(path) with its header. Collective.
std::unique_ptr<Hdf5File> create_state(const std::string& path, const StateHeader& header,
                                       MPI_Comm comm);

/// Writes the text block of temporary_name(path), closed before, and gives the file its final name.
/// Collective.
void seal_state(const std::string& path, MPI_Comm comm);

/// A sealed state, opened after its size and check sum were found right. Throws UserError with one
/// sentence on all ranks when it is missing, foreign, of another version, truncated or damaged.
class StateReader {
 public:
  StateReader(const std::string& path, MPI_Comm comm);
  const StateHeader& header() const { return header_; }
  /// Whether a field of the list is stored; a compact state has the velocity only.
  bool has(const FieldEntry& entry) const { return file_->has(entry.name); }
  /// Rows first .. first + count - 1 of one plane of a field, order (k, i), in the units of the
  /// scene. Each rank for itself; throws on that rank alone.
  template <class Real>
  void read_rows(const FieldEntry& entry, int plane, int first, int count, Real* values) const;
  /// Whether it is a checkpoint's, and what it holds for the run; alive as long as this object.
  bool has_run() const { return file_->has(run_group); }
  /// Of a format in which the flow was the same, and the rest was not.
  bool has_run_of_old() const { return file_->has("extra"); }
  LoadGroup run() const { return {*file_, run_group}; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::unique_ptr<Hdf5File> file_;
  StateHeader header_;
  std::map<std::string, double> scale_;  ///< of fields stored as scaled 16-bit integers
};

}  // namespace bedload
