#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/poisson/coprime_parts.hpp"
#include "fluid/poisson/fftw.hpp"
#include "fluid/poisson/plane_transform.hpp"

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
/// to the first row of the block in front (its own flux through their common face: so no rank waits
/// for a ghost exchange between predictor and divergence); it comes back as that block's first row.
///
/// Periodic x takes complex transforms only, two rows at a time as real and imaginary parts: FFTW's
/// real ones gain little from vector registers.
///
/// The messages of a plane travel while its neighbour is worked on: no rank waits for each plane.
template <class Real>
class DistributedTransform final : public PlaneTransform<Real> {
 public:
  DistributedTransform(const Grid& grid, int component, const Decomposition& decomposition);

  double eigenvalue(int mode, int row) const override;
  void begin_forward(Real* plane) override;
  void end_forward() override;
  void forward_row(Real* plane, int row, Real* out) override;
  void inverse_row(Real* in, int row, Real* plane) override;
  void begin_inverse() override;
  void end_inverse(Real* plane) override;

 private:
  using Base = PlaneTransform<Real>;
  using Base::basis_x_, Base::basis_z_, Base::nx_;

  int first_column(int rank) const { return all_columns_ * rank / ranks_; }
  int own_columns() const { return first_column(rank_ + 1) - first_column(rank_); }
  /// Whether z's transform is one of parts without common factors.
  bool in_parts() const { return places_.parts.size() > 1; }
  /// z's parts. In double precision the copies of the rows to and from their order take as long as
  /// parts gain.
  std::vector<int> parts_of_z() const {
    const bool gain = this->periodic_x() && this->periodic_z() && sizeof(Real) < sizeof(double);
    return gain ? coprime_parts(all_rows_) : std::vector<int>{all_rows_};
  }
  std::size_t column_row() const;  ///< reals of one row of the own columns
  /// From one row of columns_ to the next: some empty ones fill the last register of columns.
  std::size_t columns_pitch() const {
    return in_parts() ? (column_row() + 7) / 8 * 8 : column_row();
  }
  void plan(MPI_Comm comm);

  /// What one plane's messages hold on this rank.
  struct Passage {
    AlignedArray<Real> rows;     ///< own rows, columns sorted by rank, then by row
    AlignedArray<Real> columns;  ///< own columns, sorted by rank, with the additional rows;
                                 ///< backwards row after row, and the first row again
    std::vector<MPI_Request> coming, leaving;
  };
  /// Where messages begin and how long they are, by rank, in reals.
  struct Layout {
    std::vector<int> counts, offsets;
  };
  template <class Use>
  void for_pieces(Passage& passage, int k, Use use);
  Real* real_row(Real* plane, int k) const {
    return plane + this->real_pitch() * static_cast<std::size_t>(k);
  }
  Real* columns_at(int place) {
    return &columns_[static_cast<std::size_t>(place) * columns_pitch()];
  }
  Real* point_row(int k) { return columns_at(places_.point[static_cast<std::size_t>(k)]); }
  Real* mode_row(int k) { return columns_at(places_.mode[static_cast<std::size_t>(k)]); }
  void start(Passage& passage, const Real* from, const Layout& leaving, Real* to,
             const Layout& coming);
  static void finish(std::vector<MPI_Request>& requests);
  /// The passage that has begun first and has not ended.
  Passage& oldest() { return passages_[static_cast<std::size_t>(ended_ % 2)]; }
  /// The one to begin next, once what it sent last has left.
  Passage& next();

  MPI_Comm comm_;
  int rank_, ranks_, all_rows_;     ///< all_rows_: of the box
  int all_columns_, column_width_;  ///< x modes, and the reals of each
  std::vector<int> first_row_;
  Layout own_rows_;             ///< messages at the rows' end
  Layout own_columns_;          ///< at the columns' end, forwards
  Layout all_blocks_;           ///< the same, backwards: the blocks overlap
  AlignedArray<Real> line_;     ///< one row of x modes, or two rows as complex numbers ...
  AlignedArray<Real> modes_;    ///< ... and their modes, the first one again behind the last
  AlignedArray<Real> columns_;  ///< own columns and a pad, row after row as places_ says
  CoprimePlaces places_;        ///< of rows before z's transform and of modes behind it
  std::array<Passage, 2> passages_;
  std::uint64_t begun_ = 0, ended_ = 0;
  FourierPlan<Real> forward_x_, inverse_x_, forward_z_, inverse_z_;
};

}  // namespace bedload
