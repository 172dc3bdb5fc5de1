#pragma once

#include <span>
#include <vector>

#include "fluid/decomposition.hpp"
#include "fluid/grid.hpp"
#include "fluid/sphere.hpp"

namespace bedload {

/// How many markers of the spheres lie in each plane and row of cells, [plane][row]. Those of one
/// sphere, about pi (D/h)^2 of them, are spread evenly over its height and over its width
/// (Archimedes; that the two depend on each other is left out).
class MarkerMap {
 public:
  MarkerMap(const Grid& grid, std::span<const SphereState> spheres);
  double plane(int j) const { return planes_[static_cast<std::size_t>(j)]; }
  double row(int k) const { return rows_[static_cast<std::size_t>(k)]; }
  /// Of the planes and rows first .. end-1.
  double block(int first_plane, int end_plane, int first_row, int end_row) const;

 private:
  std::size_t at(int j, int k) const;

  int rows_count_;
  std::vector<double> planes_, rows_;
  std::vector<double> below_;  ///< markers in all planes < j and rows < k
};

/// Time of a stage, in units of the time that one cell takes in one, when `cuts` divide the box.
/// Predictor, markers and the pressure equation's way up go on without waiting for all ranks, its
/// way down begins when all have come there, so that the slowest rank of each of the two counts:
///
///   max (up_share cells + marker_cost markers) + max (1 - up_share) cells
///     + value_cost * numbers sent by a rank
///
/// A rank sends its six ghost planes and rows, six planes of numbers to couple slabs (2 x 3 per
/// mode), and where rows are divided all its cells twice (README.md, "On many ranks").
double stage_time(const Grid& grid, const MarkerMap& markers, const Cuts& cuts);

/// The blocks for `ranks` ranks with the shortest stage: over all ways to divide them along y and
/// z, or with `z_parts` > 0 blocks along z. Planes and rows are weighted by their cells and by some
/// share of their markers, the share that serves best. Throws UserError when there is no way to
/// give each rank a block.
Cuts choose_cuts(const Grid& grid, std::span<const SphereState> spheres, int ranks,
                 int z_parts = 0);

}  // namespace bedload
