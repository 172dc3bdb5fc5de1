#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "fluid/grid.hpp"
#include "fluid/output/hdf5_file.hpp"

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

/// Named lists of numbers that travel with a state, the same on every rank (whatever else a restart
/// needs: statistics, interior momenta).
using StateExtras = std::map<std::string, std::vector<double>>;

/// Datasets of a state, in the order of the staggered components u, v, w and the pressure.
inline constexpr std::array<const char*, 4> state_datasets{"u", "v", "w", "p"};

/// Of the block in front of the HDF5 content (front_block.hpp).
inline constexpr int state_format_version = 1;

/// Creates aside_name(path) with its header. Collective.
std::unique_ptr<Hdf5File> create_state(const std::string& path, const StateHeader& header,
                                       MPI_Comm comm);

/// Writes the text block of aside_name(path), closed before, and gives the file its final name.
/// Collective.
void seal_state(const std::string& path, MPI_Comm comm);

/// A sealed state, opened after its size and check sum were found right. Throws UserError with one
/// sentence on all ranks when it is missing, foreign, of another version, truncated or damaged.
class StateReader {
 public:
  StateReader(const std::string& path, MPI_Comm comm);
  const StateHeader& header() const { return header_; }
  /// Whether component c (u, v, w, p) is stored; a compact state has no pressure.
  bool has(int c) const { return file_->has(state_datasets[static_cast<std::size_t>(c)]); }
  /// Rows first .. first + count - 1 of one plane of component c, order (k, i), in the units of the
  /// scene. Each rank for itself; throws on that rank alone.
  template <class Real>
  void read_rows(int c, int plane, int first, int count, Real* values) const;
  StateExtras extras() const;

 private:
  std::unique_ptr<Hdf5File> file_;
  StateHeader header_;
  std::array<double, 4> scale_{1.0, 1.0, 1.0, 1.0};  ///< of scaled 16-bit components
};

}  // namespace bedload
