#pragma once

#include <mpi.h>

#include <complex>
#include <vector>

#include "fluid/fftw.hpp"
#include "fluid/field.hpp"
#include "fluid/grid.hpp"

namespace bedload {

/// Fourier transform of one real plane in x and z by complex transforms only (FFTW's real ones gain
/// nothing from vector registers in single precision).
///
/// A real row is read as nx/2 complex numbers r(2m) + i r(2m+1). One complex transform along z then
/// holds the transforms of even and odd columns together, Z_k = E_k + i O_k, which
///
///   E_k = (Z_k + conj Z_-k)/2,   O_k = (Z_k - conj Z_-k)/(2i)
///
/// take apart; rows k = 0 .. nz/2 of E and O, interleaved again, are the z transform of all
/// columns, and a complex transform along x finishes. Every length works, odd ones included. The z
/// transform goes over the plane as a whole; the x transform row by row, so that the caller can
/// work on a spectral row while it is in the first-level cache.
///
/// Forward and inverse together multiply by 1/normalisation().
template <class Real>
class PlaneTransform {
 public:
  using Complex = std::complex<Real>;

  /// Collective over `comm`, whose ranks get the same plans.
  PlaneTransform(const Grid& grid, MPI_Comm comm);

  int nx() const { return nx_; }
  int nz() const { return nz_; }
  /// Values from one row of a real plane to the next; at least nx + 1.
  std::size_t real_pitch() const { return real_pitch_; }
  std::size_t real_size() const { return real_pitch_ * static_cast<std::size_t>(nz_); }
  /// Spectral rows kz = 0 .. nz/2 of nx modes, `pitch` apart.
  int rows() const { return nz_ / 2 + 1; }
  std::size_t pitch() const { return pitch_; }
  std::size_t size() const { return pitch_ * static_cast<std::size_t>(rows()); }
  double normalisation() const { return 0.5 / (double(nx_) * double(nz_)); }

  /// Eigenvalue of h^2 times the second differences along x and z for spectral row kz, column kx:
  /// 2 cos(2 pi kx/nx) - 2 + 2 cos(2 pi kz/nz) - 2.
  double eigenvalue(int kx, int kz) const;

  void forward_z(Real* plane) const;
  void forward_row(const Real* plane, int kz, Complex* out);
  void inverse_row(Complex* in, int kz, Real* plane);
  void inverse_z(Real* plane) const;

 private:
  int nx_, nz_, columns_;
  std::size_t real_pitch_, pitch_;
  AlignedArray<Complex> scratch_;
  FourierPlan<Real> forward_z_, inverse_z_, forward_x_, inverse_x_;
};

}  // namespace bedload
