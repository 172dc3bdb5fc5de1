#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"

namespace bedload {

/// Fills what stands beyond the ends of the box, so that the plain difference across a wall is the
/// right one. A component in the plane of a wall has the wall's velocity as the mean of both sides
/// (no slip) or equal values (free slip); the component normal to it is zero on the wall's face and
/// odd about it. Periodic neighbours are copied along x; along z the field's row table does that
/// already, or the exchange of rows, and along y the exchange of planes.
///
/// The face of a lower wall is "cell" -1 of the normal component, that of an upper wall is the last
/// cell. First rows (x), then planes (z), then the block (y): corners follow from what was filled
/// before.
template <class Real>
class WallGhosts {
 public:
  /// `decomposition` tells which walls this rank's block lies at; both must outlive this object.
  WallGhosts(const Grid& grid, const Decomposition& decomposition)
      : grid_(grid), decomposition_(decomposition) {
    for (std::size_t d = 0; d < 3; ++d)
      for (std::size_t end = 0; end < 2; ++end)
        for (std::size_t c = 0; c < 3; ++c)
          if (grid.walls[d][end] == Wall::no_slip)
            mirror_[d][end][c] = {Real(-1), static_cast<Real>(2.0 * grid.wall_velocity[d][end][c])};
  }

  /// x ghosts of one row of component c.
  void close_row(Real* row, int c) const {
    const int nx = grid_.cells[0];
    if (grid_.periodic(0)) {
      row[-1] = row[nx - 1];
      row[nx] = row[0];
    } else if (c == 0) {
      row[-1] = row[nx - 1] = Real(0);
      row[nx] = -row[nx - 2];
    } else {
      row[-1] = mirror(0, 0, c)(row[0]);
      row[nx] = mirror(0, 1, c)(row[nx - 1]);
    }
  }

  /// Rows of plane j beyond z walls.
  void close_plane(Field<Real>& velocity, int j) const {
    const int nz = velocity.nz();
    if (decomposition_.at_back_wall()) {
      for (const int c : {0, 1})
        reflect(mirror(2, 0, c), velocity.row(j, 0, c), velocity.row(j, -1, c));
      clear(velocity.row(j, -1, 2));
    }
    if (decomposition_.at_front_wall()) {
      for (const int c : {0, 1})
        reflect(mirror(2, 1, c), velocity.row(j, nz - 1, c), velocity.row(j, nz, c));
      clear(velocity.row(j, nz - 1, 2));
      reflect(odd, velocity.row(j, nz - 2, 2), velocity.row(j, nz, 2));
    }
  }

  /// Planes beyond y walls, for the ranks beside them.
  void close_block(Field<Real>& velocity) const {
    const int top = velocity.planes() - 1;
    for (int k = -1; k <= velocity.nz(); ++k) {
      if (decomposition_.at_lower_wall()) {
        for (const int c : {0, 2})
          reflect(mirror(1, 0, c), velocity.row(0, k, c), velocity.row(-1, k, c));
        clear(velocity.row(-1, k, 1));
      }
      if (decomposition_.at_upper_wall()) {
        for (const int c : {0, 2})
          reflect(mirror(1, 1, c), velocity.row(top, k, c), velocity.row(top + 1, k, c));
        clear(velocity.row(top, k, 1));
        reflect(odd, velocity.row(top - 1, k, 1), velocity.row(top + 1, k, 1));
      }
    }
  }

  /// The upper wall's own face, row k of plane j of storage: no flow passes.
  void close_wall_face(Field<Real>& velocity, int j, int k) const { clear(velocity.row(j, k, 1)); }

  /// Ghosts within the own planes, from the own cells alone.
  void close_own_planes(Field<Real>& velocity) const {
    for (int j = 0; j < velocity.planes(); ++j) {
      for (int k = 0; k < velocity.nz(); ++k)
        for (int c = 0; c < 3; ++c) close_row(velocity.row(j, k, c), c);
      close_plane(velocity, j);
    }
  }

  /// All other ghosts: those of the neighbour ranks, and beyond walls. Collective.
  void fill(Field<Real>& velocity) const {
    decomposition_.exchange_rows(velocity);
    if (decomposition_.divides_rows())  // a block of one row reflects its neighbour's at the wall
      for (int j = 0; j < velocity.planes(); ++j) close_plane(velocity, j);
    decomposition_.exchange_planes(velocity);
    close_block(velocity);
  }

  /// Ghosts of plane j of a quantity without gradient at walls (the pressure).
  void close_scalar(Field<Real>& scalar, int j) const {
    const int nx = grid_.cells[0], nz = scalar.nz();
    for (int k = 0; k <= nz; ++k) {
      Real* row = scalar.row(j, k);
      row[-1] = grid_.periodic(0) ? row[nx - 1] : row[0];
      row[nx] = grid_.periodic(0) ? row[0] : row[nx - 1];
    }
    if (decomposition_.at_back_wall()) reflect(even, scalar.row(j, 0), scalar.row(j, -1));
    if (decomposition_.at_front_wall()) reflect(even, scalar.row(j, nz - 1), scalar.row(j, nz));
  }

  /// All ghosts of such a quantity, from its own cells and the neighbour ranks'. Collective.
  void fill_scalar(Field<Real>& scalar) const {
    const int top = scalar.planes() - 1;
    for (int j = 0; j <= top; ++j) close_scalar(scalar, j);
    decomposition_.exchange(scalar);
    for (int k = -1; k <= scalar.nz(); ++k) {
      if (decomposition_.at_lower_wall()) reflect(even, scalar.row(0, k), scalar.row(-1, k));
      if (decomposition_.at_upper_wall()) reflect(even, scalar.row(top, k), scalar.row(top + 1, k));
    }
  }

 private:
  /// ghost = sign * inner + offset
  struct Mirror {
    Real sign = Real(1), offset = Real(0);
    Real operator()(Real inner) const { return sign * inner + offset; }
  };
  static constexpr Mirror even{}, odd{Real(-1), Real(0)};

  const Mirror& mirror(int direction, int end, int component) const {
    return mirror_[static_cast<std::size_t>(direction)][static_cast<std::size_t>(end)]
                  [static_cast<std::size_t>(component)];
  }
  void reflect(const Mirror& mirror, const Real* from, Real* to) const {
    for (int i = -1; i <= grid_.cells[0]; ++i) to[i] = mirror(from[i]);
  }
  void clear(Real* row) const { std::fill_n(row - 1, grid_.cells[0] + 2, Real(0)); }

  const Grid& grid_;
  const Decomposition& decomposition_;
  std::array<std::array<std::array<Mirror, 3>, 2>, 3> mirror_{};
};

}  // namespace bedload
