#pragma once

#include <gtest/gtest.h>
#include <mpi.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <sstream>
#include <string>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/flow_view.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload::test {

inline int world_rank() { return rank_in(MPI_COMM_WORLD); }
inline int world_size() { return size_of(MPI_COMM_WORLD); }

/// A folder of one test for all ranks, removed at its end.
class Folder {
 public:
  Folder() {
    char name[] = "/tmp/bedload_output_XXXXXX";
    if (world_rank() == 0 && !mkdtemp(name)) std::abort();
    MPI_Bcast(name, sizeof name, MPI_CHAR, 0, MPI_COMM_WORLD);
    name_ = name;
  }
  ~Folder() {
    MPI_Barrier(MPI_COMM_WORLD);
    if (world_rank() == 0) std::filesystem::remove_all(name_);
  }
  std::string operator/(const std::string& file) const { return name_ + "/" + file; }
  const std::string& name() const { return name_; }

 private:
  std::string name_;
};

/// A channel of length 1 x 0.5 x 1 of cubic cells: no slip below (the wall moving), free slip
/// above.
inline Grid channel_grid(int cells_along_x) {
  return {.cells = {cells_along_x, cells_along_x / 2, cells_along_x},
          .length = {1.0, 0.5, 1.0},
          .h = 1.0 / cells_along_x,
          .walls = {{{Wall::periodic, Wall::periodic},
                     {Wall::no_slip, Wall::free_slip},
                     {Wall::periodic, Wall::periodic}}},
          .wall_velocity = {{{}, {{{0.7, 0.0, 0.4}, {0.0, 0.0, 0.0}}}, {}}}};
}

/// The same, its planes drawn to the lower wall.
inline Grid stretched_grid(int cells_along_x, double stretching) {
  Grid grid = channel_grid(cells_along_x);
  grid.y_faces = faces_near_walls(grid.cells[1], grid.length[1], stretching, {true, false});
  return grid;
}

/// Value of component c (3: pressure) in global cell (i, j, k).
using CellValue = std::function<double(int c, int i, int j, int k)>;
/// Value of component c at a place.
using PlaceValue = std::function<double(int c, double x, double y, double z)>;

template <class Real>
struct Flow {
  Grid grid;
  Decomposition decomposition;
  FlowFields<Real> fields;
  Field<Real>&velocity, &pressure;  ///< of fields

  Flow(const Grid& g, MPI_Comm comm, const Cuts& cuts)
      : grid(g),
        decomposition(g, comm, cuts),
        fields(g, decomposition.extent()),
        velocity(fields[Stored::velocity]),
        pressure(fields[Stored::pressure]) {}
  /// Even blocks, two side by side along z where the number of ranks allows.
  Flow(const Grid& g, MPI_Comm comm)
      : Flow(g, comm, even_cuts(g, size_of(comm), size_of(comm) % 2 == 0 ? 2 : 1)) {}

  Real& at(int c, int i, int j, int k) {
    return c == 3 ? pressure.row(j, k)[i] : velocity.row(j, k, c)[i];
  }
  template <class Visitor>
  void each(Visitor&& visit) {
    for (int c = 0; c < 4; ++c)
      for (int j = 0; j < decomposition.planes(); ++j)
        for (int k = 0; k < decomposition.rows(); ++k)
          for (int i = 0; i < grid.cells[0]; ++i) visit(c, i, j, k);
  }
  /// Own cells, then the ghosts that the writers need: the neighbours', 0 on the lower y wall.
  void fill(const CellValue& value) {
    each([&](int c, int i, int j, int k) {
      at(c, i, j, k) =
          static_cast<Real>(value(c, i, decomposition.first() + j, decomposition.first_row() + k));
    });
    for (int j = 0; j < decomposition.planes(); ++j) wrap_x_ghosts(velocity, j);
    decomposition.exchange(velocity);
  }
  void fill(const PlaceValue& value) {
    fill(CellValue([&](int c, int i, int j, int k) {
      return value(c, place(c, 0, i), place(c, 1, j), place(c, 2, k));
    }));
  }
  double place(int c, int d, int n) const {
    if (d == 1) return c == d ? grid.y_face(n) : grid.y_centre(n);
    return c == d ? grid.face(n) : grid.centre(n);
  }

  FlowView<Real> view(double time = 0.25, std::int64_t step = 42, double driving = -1.5) const {
    return {grid, decomposition, fields, time, step, driving};
  }
};

/// A different number with all bits in use in every cell. One compiled copy: inlined at two places
/// it might be contracted to fused operations in two ways, and differ in the last bit.
[[gnu::noinline]] inline double scattered(int c, int i, int j, int k) {
  return std::sin(1.0 + 12.9898 * i + 78.233 * j + 37.719 * k + 4.581 * c);
}

/// Runs `work` and gives back the sentence of the UserError that it throws, "" if none.
inline std::string complaint(const std::function<void()>& work) {
  try {
    work();
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

inline std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace bedload::test
