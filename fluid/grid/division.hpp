#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// What forcing costs in each plane and row of cells, [plane][row], in units of the time that one
/// cell takes in a stage. The markers of a sphere, pi (D/h)^2 of them for a density of 1, are
/// spread evenly over its height and over its width (Archimedes; that the two depend on each other
/// is left out).
class ForcingWork {
 public:
  /// Markers of mobile spheres are placed and weighed as well.
  ForcingWork(const Grid& grid, std::span<const SphereState> spheres,
              const Settings::Spheres& settings);
  /// Adds the other ranks' spheres to those of the first one of `comm`; every rank has named
  /// spheres that no other one has. Collective.
  void add_up_on_first(MPI_Comm comm);
  double plane(int j) const { return planes_[static_cast<std::size_t>(j)]; }
  double row(int k) const { return rows_[static_cast<std::size_t>(k)]; }
  /// Of the planes and rows first .. end-1.
  double block(int first_plane, int end_plane, int first_row, int end_row) const;
  /// Whether spheres concern the blocks on both sides of the cut before plane j, before row k (0:
  /// the seam of a periodic direction).
  bool crosses_plane(int j) const { return plane_crossed_[static_cast<std::size_t>(j)] != 0; }
  bool crosses_row(int k) const { return row_crossed_[static_cast<std::size_t>(k)] != 0; }

 private:
  std::size_t at(int j, int k) const;

  int rows_count_;
  std::vector<double> planes_, rows_;
  std::vector<double> below_;  ///< in all planes < j and rows < k
  std::vector<char> plane_crossed_, row_crossed_;
};

/// Time of a stage, in units of the time that one cell takes in one, when `cuts` divide the box.
/// Predictor, forcing and the pressure equation's upward elimination go on without waiting for all
/// ranks, its downward substitution begins when all have come there, so that the slowest rank of
/// each of the two counts:
///
///   max (up cells + forcing) + max (down cells) + value_cost * numbers sent by a rank
///
/// up + down = 1 in the slab on a lower wall; the others carry the plane below along as an unknown
/// and pay some more for each cell. Ranks with spheres in common wait for each other between
/// predictor and forcing, too: among them max (up cells) + max (forcing) stands for the first term.
/// A rank sends its six ghost planes and rows, six planes of numbers to couple slabs (2 x 3 per
/// mode), and where rows are divided all its cells twice (README.md, "On many ranks").
double stage_time(const Grid& grid, const ForcingWork& forcing, const Cuts& cuts);

/// The blocks for `ranks` ranks with the shortest stage: over all ways to divide them along y and
/// z, or with `z_parts` > 0 blocks along z. Planes and rows are weighted by their cells and by some
/// share of the forcing, whichever serves best. Throws UserError when there is
/// no way to give each rank a block.
Cuts choose_cuts(const Grid& grid, std::span<const SphereState> spheres, int ranks, int z_parts = 0,
                 const Settings::Spheres& settings = {});

/// The same for all ranks of `comm` where each knows some of the spheres, `mine`, and none that
/// another one has: what they hold does not grow with the number of all spheres. Collective.
Cuts choose_cuts_together(MPI_Comm comm, const Grid& grid, std::span<const SphereState> mine,
                          int z_parts = 0, const Settings::Spheres& settings = {});

}  // namespace bedload
