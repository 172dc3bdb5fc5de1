#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/poisson/basis.hpp"

namespace bedload {

/// Transform of a real plane in x and z into the functions in which second differences are diagonal
/// (basis.hpp): Fourier where periodic, sine or cosine between walls. Two kinds: of a plane that
/// this rank has as a whole (local_transform.hpp), and of one whose rows are divided over ranks
/// (distributed_transform.hpp).
///
/// Real planes hold the block's nz rows and one more, in an order of their own. Spectral planes
/// hold rows() rows of modes(), `pitch` modes apart, each of parts() real numbers. Whole-plane
/// steps are collective over the ranks that share the plane; row steps are not, so that the caller
/// can work on a spectral row while it is in the first-level cache. Forward and inverse together
/// multiply by 1/normalisation(). Forwards: begin_forward, end_forward, then the rows; inverse: the
/// rows, begin_inverse, end_inverse. One more plane may begin before the last one ends.
template <class Real>
class PlaneTransform {
 public:
  virtual ~PlaneTransform() = default;
  PlaneTransform(const PlaneTransform&) = delete;
  PlaneTransform& operator=(const PlaneTransform&) = delete;

  int nx() const { return nx_; }
  int nz() const { return nz_; }  ///< rows of the block
  bool periodic_x() const { return basis_x_ == Basis::periodic; }
  bool periodic_z() const { return basis_z_ == Basis::periodic; }
  /// Whether row nz takes part: forwards as what this block adds to the first row of the block in
  /// front, back as that row.
  bool has_row_in_front() const { return divided_; }
  /// Where row k of a real plane begins; it takes real_pitch() values, at least nx + 1.
  std::size_t real_place(int k) const { return real_places_[static_cast<std::size_t>(k)]; }
  std::size_t real_pitch() const { return real_pitch_; }
  std::size_t real_size() const { return real_pitch_ * static_cast<std::size_t>(nz_ + 1); }

  int rows() const { return rows_; }
  int modes() const { return modes_; }
  /// Real numbers that make up one mode: 2 (real and imaginary part) or 1.
  int parts() const { return periodic_x() || periodic_z() ? 2 : 1; }
  /// Modes from one spectral row to the next, and in all, padding included.
  std::size_t pitch() const { return pitch_; }
  std::size_t size() const { return pitch_ * static_cast<std::size_t>(rows_); }

  double normalisation() const { return normalisation_; }
  /// Eigenvalue of h^2 times the second differences along x and z; zero for the mean of the
  /// pressure alone.
  virtual double eigenvalue(int mode, int row) const = 0;

  /// Whether messages are under way between begin and end of a whole-plane step.
  bool exchanges() const { return divided_; }
  virtual void begin_forward(Real* plane) = 0;
  virtual void end_forward() = 0;
  virtual void forward_row(Real* plane, int row, Real* out) = 0;
  virtual void inverse_row(Real* in, int row, Real* plane) = 0;
  virtual void begin_inverse() = 0;
  virtual void end_inverse(Real* plane) = 0;

 protected:
  PlaneTransform(const Grid& grid, int component, const Decomposition& decomposition)
      : nx_(grid.cells[0]),
        nz_(decomposition.rows()),
        basis_x_(basis_of(grid, component, 0)),
        basis_z_(basis_of(grid, component, 2)),
        divided_(decomposition.divides_rows()),
        real_pitch_(round_up(static_cast<std::size_t>(nx_) + 1, cache_line / sizeof(Real))),
        real_places_(static_cast<std::size_t>(nz_) + 1) {
    for (std::size_t k = 0; k < real_places_.size(); ++k) real_places_[k] = k * real_pitch_;
  }

  void shape_modes(int rows, int modes) {
    rows_ = rows;
    modes_ = modes;
    pitch_ = round_up(static_cast<std::size_t>(modes), cache_line / sizeof(Real));
  }
  static std::size_t round_up(std::size_t n, std::size_t to) { return (n + to - 1) / to * to; }

  int nx_, nz_;
  Basis basis_x_, basis_z_;
  bool divided_;
  std::size_t real_pitch_;
  std::vector<std::size_t> real_places_;
  int rows_ = 0, modes_ = 0;
  std::size_t pitch_ = 0;
  double normalisation_ = 1.0;
};

/// The kind that the decomposition asks for. Collective over its ranks, which get the same plans.
template <class Real>
std::unique_ptr<PlaneTransform<Real>> make_plane_transform(const Grid& grid, int component,
                                                           const Decomposition& decomposition);

}  // namespace bedload
