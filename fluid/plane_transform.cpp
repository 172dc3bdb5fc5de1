#include "fluid/plane_transform.hpp"

#include <cmath>
#include <numbers>

namespace bedload {
namespace {

std::size_t round_up(std::size_t n, std::size_t to) { return (n + to - 1) / to * to; }

/// Row pair (Z_k, Z_-k) of packed columns to twice the row k of unpacked columns.
template <class Real>
void take_apart(int columns, const Real* a, const Real* b, Real* __restrict out) {
  for (int m = 0; m < columns; ++m) {
    const Real re = a[2 * m], im = a[2 * m + 1];
    const Real re_minus = b[2 * m], im_minus = b[2 * m + 1];
    out[4 * m] = re + re_minus;  // 2 E
    out[4 * m + 1] = im - im_minus;
    out[4 * m + 2] = im + im_minus;  // 2 O
    out[4 * m + 3] = re_minus - re;
  }
}

/// The reverse: Z_k = E + i O and Z_-k = conj E + i conj O.
template <class Real>
void put_together(int columns, const Real* in, Real* __restrict a, Real* __restrict b) {
  for (int m = 0; m < columns; ++m) {
    const Real e_re = in[4 * m], e_im = in[4 * m + 1];
    const Real o_re = in[4 * m + 2], o_im = in[4 * m + 3];
    a[2 * m] = e_re - o_im;
    a[2 * m + 1] = e_im + o_re;
    b[2 * m] = e_re + o_im;
    b[2 * m + 1] = o_re - e_im;
  }
}

/// Rows k = 0 and k = nz/2 are their own partners; their columns are real.
template <class Real>
void put_real_together(int columns, const Real* in, Real* __restrict a) {
  for (int m = 0; m < columns; ++m) {
    a[2 * m] = in[4 * m];
    a[2 * m + 1] = in[4 * m + 2];
  }
}

}  // namespace

template <class Real>
PlaneTransform<Real>::PlaneTransform(const Grid& grid, MPI_Comm comm)
    : nx_(grid.cells[0]), nz_(grid.cells[2]), columns_((nx_ + 1) / 2) {
  const std::size_t n = static_cast<std::size_t>(nx_);
  real_pitch_ = round_up(n + 1, cache_line / sizeof(Real));
  pitch_ = round_up(n, cache_line / sizeof(Complex));
  scratch_ = AlignedArray<Complex>(n + 1);
  AlignedArray<Real> plane(real_size());
  AlignedArray<Complex> row(pitch_);
  using Raw = typename Fftw<Real>::Complex;
  Raw* in_plane = reinterpret_cast<Raw*>(plane.data());
  Raw* in_row = reinterpret_cast<Raw*>(row.data());
  Raw* scratch = reinterpret_cast<Raw*>(scratch_.data());
  const int step = static_cast<int>(real_pitch_ / 2);
  const auto along_z = [&](int sign) {
    return FourierPlan<Real>(
        Fftw<Real>::plan(nz_, columns_, in_plane, step, 1, in_plane, step, 1, sign));
  };
  const auto along_x = [&](Raw* in, Raw* out, int sign) {
    return FourierPlan<Real>(Fftw<Real>::plan(nx_, 1, in, 1, nx_, out, 1, nx_, sign));
  };
  plan_alike<Real>(comm, [&] {
    forward_z_ = along_z(FFTW_FORWARD);
    inverse_z_ = along_z(FFTW_BACKWARD);
    forward_x_ = along_x(scratch, in_row, FFTW_FORWARD);
    inverse_x_ = along_x(in_row, scratch, FFTW_BACKWARD);
  });
}

template <class Real>
double PlaneTransform<Real>::eigenvalue(int kx, int kz) const {
  const auto second_difference = [](int k, int n) {
    const double s = std::sin(std::numbers::pi * k / n);
    return -4.0 * s * s;
  };
  return second_difference(kx, nx_) + second_difference(kz, nz_);
}

template <class Real>
void PlaneTransform<Real>::forward_z(Real* plane) const {
  if (nx_ % 2 != 0)  // the last packed number has no partner
    for (int k = 0; k < nz_; ++k)
      plane[static_cast<std::size_t>(k) * real_pitch_ + static_cast<std::size_t>(nx_)] = 0;
  auto* packed = reinterpret_cast<Complex*>(plane);
  forward_z_(packed, packed);
}

template <class Real>
void PlaneTransform<Real>::forward_row(const Real* plane, int kz, Complex* out) {
  const Real* a = plane + static_cast<std::size_t>(kz) * real_pitch_;
  const Real* b = plane + static_cast<std::size_t>((nz_ - kz) % nz_) * real_pitch_;
  take_apart(columns_, a, b, reinterpret_cast<Real*>(scratch_.data()));
  forward_x_(scratch_.data(), out);
}

template <class Real>
void PlaneTransform<Real>::inverse_row(Complex* in, int kz, Real* plane) {
  inverse_x_(in, scratch_.data());
  if (nx_ % 2 != 0) scratch_[static_cast<std::size_t>(nx_)] = Complex{};
  const Real* row = reinterpret_cast<const Real*>(scratch_.data());
  const int partner = (nz_ - kz) % nz_;
  Real* a = plane + static_cast<std::size_t>(kz) * real_pitch_;
  if (partner == kz)
    put_real_together(columns_, row, a);
  else
    put_together(columns_, row, a, plane + static_cast<std::size_t>(partner) * real_pitch_);
}

template <class Real>
void PlaneTransform<Real>::inverse_z(Real* plane) const {
  auto* packed = reinterpret_cast<Complex*>(plane);
  inverse_z_(packed, packed);
}

template class PlaneTransform<float>;
template class PlaneTransform<double>;

}  // namespace bedload
