#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>

#include "fluid/basis.hpp"
#include "fluid/fftw.hpp"
#include "fluid/field.hpp"
#include "fluid/grid.hpp"

namespace bedload {

/// Transform of one real plane in x and z into the functions in which second differences are
/// diagonal (basis.hpp): Fourier where periodic, sine or cosine between walls.
///
/// z comes first and goes over the plane as a whole; the x transform follows row by row, so that
/// the caller can work on a spectral row while it is in the first-level cache. What a spectral row
/// holds:
///
///   z         x         rows      modes of a row
///   periodic  periodic  nz/2+1    nx complex
///   periodic  walls     nz/2+1    nx complex (x transform of real and imaginary parts)
///   walls     periodic  nz        nx/2+1 complex
///   walls     walls     nz        nx real
///
/// Periodic z takes complex transforms only (FFTW's real ones gain nothing from vector registers in
/// single precision): a real row is read as nx/2 complex numbers r(2m) + i r(2m+1). One complex
/// transform along z then holds the transforms of even and odd columns together, Z_k = E_k + i O_k,
/// which
///
///   E_k = (Z_k + conj Z_-k)/2,   O_k = (Z_k - conj Z_-k)/(2i)
///
/// take apart; rows k = 0 .. nz/2 of E and O, interleaved again, are the z transform of all
/// columns. Every length works, odd ones included.
///
/// Forward and inverse together multiply by 1/normalisation().
template <class Real>
class PlaneTransform {
 public:
  /// For a velocity component or the pressure. Collective over `comm`, whose ranks get the same
  /// plans.
  PlaneTransform(const Grid& grid, int component, MPI_Comm comm);

  int nx() const { return nx_; }
  int nz() const { return nz_; }
  bool periodic_x() const { return basis_x_ == Basis::periodic; }
  bool periodic_z() const { return basis_z_ == Basis::periodic; }
  /// Values from one row of a real plane to the next; at least nx + 1.
  std::size_t real_pitch() const { return real_pitch_; }
  std::size_t real_size() const { return real_pitch_ * static_cast<std::size_t>(nz_); }

  int rows() const { return periodic_z() ? nz_ / 2 + 1 : nz_; }
  int modes() const { return periodic_x() && !periodic_z() ? nx_ / 2 + 1 : nx_; }
  /// Real numbers that make up one mode: 2 (real and imaginary part) or 1.
  int parts() const { return periodic_x() || periodic_z() ? 2 : 1; }
  /// Modes from one spectral row to the next, and in all, padding included.
  std::size_t pitch() const { return pitch_; }
  std::size_t size() const { return pitch_ * static_cast<std::size_t>(rows()); }

  double normalisation() const { return normalisation_; }
  /// Eigenvalue of h^2 times the second differences along x and z.
  double eigenvalue(int mode, int row) const {
    return second_difference(basis_x_, mode, nx_) + second_difference(basis_z_, row, nz_);
  }

  void forward_z(Real* plane) const;
  void forward_row(Real* plane, int row, Real* out);
  void inverse_row(Real* in, int row, Real* plane);
  void inverse_z(Real* plane) const;

 private:
  int nx_, nz_, columns_;
  Basis basis_x_, basis_z_;
  double normalisation_;
  std::size_t real_pitch_, pitch_;
  AlignedArray<Real> scratch_;
  FourierPlan<Real> forward_z_, inverse_z_, forward_x_, inverse_x_;
};

}  // namespace bedload
