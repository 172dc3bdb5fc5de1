#pragma once

#include <cstddef>

#include "fluid/poisson/fftw.hpp"
#include "fluid/poisson/plane_transform.hpp"

namespace bedload {

/// The transform of a plane that this rank has as a whole. z comes first and goes over the plane as
/// a whole; the x transform follows row by row. What a spectral row holds:
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
/// columns. Every length works, odd ones included. FFTW vectorises over columns where it has
/// straight code for all points, but not with factors in between, so the rows stand in the order
/// that needs none (coprime_parts.hpp): 130 points are 10 by 13.
template <class Real>
class LocalTransform final : public PlaneTransform<Real> {
 public:
  LocalTransform(const Grid& grid, int component, const Decomposition& decomposition);

  double eigenvalue(int mode, int row) const override {
    return second_difference(basis_x_, mode, nx_) + second_difference(basis_z_, row, nz_);
  }
  void begin_forward(Real* plane) override;
  void end_forward() override {}
  void forward_row(Real* plane, int row, Real* out) override;
  void inverse_row(Real* in, int row, Real* plane) override;
  void begin_inverse() override {}
  void end_inverse(Real* plane) override;

 private:
  using Base = PlaneTransform<Real>;
  using Base::basis_x_, Base::basis_z_, Base::nx_, Base::nz_, Base::real_pitch_, Base::real_places_;
  using Base::periodic_x, Base::periodic_z;

  Real* mode_row(Real* plane, int k) const {
    return plane + mode_places_[static_cast<std::size_t>(k)];
  }

  int columns_;                           // pairs of columns of the block
  std::vector<std::size_t> mode_places_;  // where row k of a plane's z transform begins
  AlignedArray<Real> scratch_;
  FourierPlan<Real> forward_z_, inverse_z_, forward_x_, inverse_x_;
};

}  // namespace bedload
