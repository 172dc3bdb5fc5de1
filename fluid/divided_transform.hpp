#pragma once

#include <mpi.h>

#include <cstddef>
#include <vector>

#include "fluid/decomposition.hpp"
#include "fluid/fftw.hpp"
#include "fluid/plane_transform.hpp"

namespace bedload {

/// The transform of a plane whose rows are divided over several ranks. x comes first, on the own
/// rows; then the ranks of a plane exchange rows for columns, so that each holds some columns of x
/// modes with all their rows; z comes last, down these columns. Whole-plane steps do the rest, so
/// that a spectral "row" is all that a rank holds of the plane: z mode after z mode, each with the
/// own x modes.
///
///   z         x         z modes   own columns
///   periodic  periodic  nz        share of nx/2+1, complex
///   periodic  walls     nz/2+1    share of nx, complex
///   walls     periodic  nz        share of nx/2+1, complex
///   walls     walls     nz        share of nx, real
///
/// One more real row than the block has goes along both ways. Forwards it holds what this rank adds
/// to the first row of the block in front (its own flux through their common face: so nobody waits
/// for a ghost exchange between predictor and divergence); it comes back as that block's first row.
template <class Real>
class DividedTransform final : public PlaneTransform<Real> {
 public:
  DividedTransform(const Grid& grid, int component, const Decomposition& blocks);

  double eigenvalue(int mode, int row) const override;
  void forward_plane(Real* plane) override;
  void forward_row(Real* plane, int row, Real* out) override;
  void inverse_row(Real* in, int row, Real* plane) override;
  void inverse_plane(Real* plane) override;
  std::size_t bytes() const override;

 private:
  using Base = PlaneTransform<Real>;
  using Base::basis_x_, Base::basis_z_, Base::nx_;

  int first_column(int rank) const { return all_columns_ * rank / ranks_; }
  int own_columns() const { return first_column(rank_ + 1) - first_column(rank_); }
  std::size_t column_row() const;  ///< reals of one row of the own columns
  void plan(MPI_Comm comm);

  MPI_Comm comm_;
  int rank_, ranks_, all_rows_;     ///< all_rows_: of the box
  int all_columns_, column_width_;  ///< x modes, and the reals of each
  std::vector<int> first_row_;
  std::vector<int> row_counts_, row_offsets_;        ///< of messages at the rows' end, in reals
  std::vector<int> column_counts_, column_offsets_;  ///< where columns come from
  std::vector<int> block_offsets_;                   ///< where they go back to
  AlignedArray<Real> line_;                          ///< one row of x modes
  AlignedArray<Real> rows_;      ///< own rows, columns sorted by rank, then by row
  AlignedArray<Real> received_;  ///< own columns, sorted by rank, with the additional rows
  AlignedArray<Real> columns_;   ///< own columns, row after row, and the first row again
  FourierPlan<Real> forward_x_, inverse_x_, forward_z_, inverse_z_;
};

}  // namespace bedload
