#pragma once

#include <utility>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/sphere.hpp"

namespace bedload {

/// Brings home what markers spread into ghosts, and refreshes ghosts, in the rows near spheres
/// only. Which rows these are follows from the spheres' positions by the same arithmetic on every
/// rank, so that neighbours agree without a message.
class MarkerHalo {
 public:
  MarkerHalo(const Grid& grid, const Decomposition& decomposition);

  void forget();                                 ///< no rows
  void mark(const Vec3& centre, double radius);  ///< adds the rows that a sphere may touch
  void keep() { kept_ = marked_; }               ///< remembers the present rows ...
  void reset() { marked_ = kept_; }              ///< ... and goes back to them
  void finish();                                 ///< makes lists of the marked rows

  /// Whether rows are exchanged with the blocks below or above.
  bool crosses_planes() const { return !below_.empty() || !above_.empty(); }

  /// Empties the ghosts of the marked rows. Markers may then spread.
  template <class Real>
  void clear_ghosts(Field<Real>& field) const;
  /// Empties all that collect() and refresh() wrote: the marked rows of the ghosts and of the cells
  /// next to them, and the ends of the marked rows at the seam.
  template <class Real>
  void clear_touched(Field<Real>& field) const;
  /// Adds ghosts of the marked rows to the cells that they stand for. Collective.
  template <class Real>
  void collect(Field<Real>& field) const;
  /// Makes the ghosts of the marked rows valid again. Collective.
  template <class Real>
  void refresh(Field<Real>& field) const;

 private:
  /// Flags of this block's rows; ghost planes and ghost rows count, planes and rows from -1.
  struct Marks {
    std::vector<char> below, above;  ///< z rows at the interface with the lower and upper block
    std::vector<char> back, front;   ///< planes at the interface with the block behind, in front
    std::vector<char> seam;          ///< rows (plane, z row) that reach an end of periodic x
  };
  void mark_planes(std::vector<char>& planes, double y, double half_width) const;
  void mark_rows(std::vector<char>& rows, std::size_t first, double z, double half_width) const;

  const Grid& grid_;
  const Decomposition& decomposition_;
  Marks marked_, kept_;
  std::vector<int> below_, above_;         ///< own z rows exchanged between planes
  std::vector<int> back_, front_;          ///< planes, ghost ones included, exchanged between rows
  std::vector<std::pair<int, int>> seam_;  ///< (j, k)
};

}  // namespace bedload
