#include "fluid/poisson/local_transform.hpp"

#include <algorithm>

#include "fluid/poisson/coprime_parts.hpp"

namespace bedload {
namespace {

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
LocalTransform<Real>::LocalTransform(const Grid& grid, int component,
                                     const Decomposition& decomposition)
    : Base(grid, component, decomposition), columns_((nx_ + 1) / 2) {
  // Sine and cosine transforms there and back multiply by twice the cells; along periodic z, too,
  // because taking apart doubles.
  this->normalisation_ = 1.0 / (2.0 * nz_ * (periodic_x() ? 1.0 : 2.0) * nx_);
  this->shape_modes(periodic_z() ? nz_ / 2 + 1 : nz_,
                    periodic_x() && !periodic_z() ? nx_ / 2 + 1 : nx_);
  scratch_ = AlignedArray<Real>(2 * static_cast<std::size_t>(nx_) + 2);
  AlignedArray<Real> plane(this->real_size()), row(2 * this->pitch());
  Real *p = plane.data(), *r = row.data(), *s = scratch_.data();
  using Plan = FourierPlan<Real>;
  const int step = static_cast<int>(real_pitch_);
  // Whole registers of packed columns, those of the pad included.
  const CoprimePlaces places(coprime_parts(nz_));
  const FftwShape packed_columns{places.parts, step / 2, step / 2, 1};
  const FftwShape columns{{nz_}, nx_, step, 1};
  const FftwShape complex_row{{nx_}, 1}, real_row{{nx_}, 1}, two_parts{{nx_}, 2, 2, 1};
  if (periodic_z()) {
    for (std::size_t k = 0; k < places.point.size(); ++k) {
      real_places_[k] = static_cast<std::size_t>(places.point[k]) * real_pitch_;
      mode_places_.push_back(static_cast<std::size_t>(places.mode[k]) * real_pitch_);
    }
  }
  plan_alike<Real>(decomposition.comm(), 0, [&] {
    if (periodic_z()) {
      forward_z_ = Plan::complex(packed_columns, p, p, FFTW_FORWARD);
      inverse_z_ = Plan::complex(packed_columns, p, p, FFTW_BACKWARD);
    } else {
      forward_z_ = Plan::real(basis_z_, true, columns, p, p);
      inverse_z_ = Plan::real(basis_z_, false, columns, p, p);
    }
    if (periodic_x() && periodic_z()) {
      forward_x_ = Plan::complex(complex_row, s, r, FFTW_FORWARD);
      inverse_x_ = Plan::complex(complex_row, r, s, FFTW_BACKWARD);
    } else if (periodic_x()) {
      forward_x_ = Plan::to_complex(complex_row, p, r);
      inverse_x_ = Plan::to_real(complex_row, r, p);
    } else if (periodic_z()) {
      forward_x_ = Plan::real(basis_x_, true, two_parts, s, r);
      inverse_x_ = Plan::real(basis_x_, false, two_parts, r, s);
    } else {
      forward_x_ = Plan::real(basis_x_, true, real_row, p, r);
      inverse_x_ = Plan::real(basis_x_, false, real_row, r, p);
    }
  });
}

template <class Real>
void LocalTransform<Real>::begin_forward(Real* plane) {
  if (periodic_z()) {  // the pad's columns, and the partner of an odd last number
    const std::size_t own = static_cast<std::size_t>(nx_);
    for (int k = 0; k < nz_; ++k)
      std::fill_n(plane + real_places_[static_cast<std::size_t>(k)] + own, real_pitch_ - own,
                  Real(0));
  }
  forward_z_(plane, plane);
}

template <class Real>
void LocalTransform<Real>::forward_row(Real* plane, int row, Real* out) {
  if (!periodic_z()) {
    forward_x_(plane + this->real_place(row), out);
    return;
  }
  take_apart(columns_, mode_row(plane, row), mode_row(plane, (nz_ - row) % nz_), scratch_.data());
  forward_x_(scratch_.data(), out);
}

template <class Real>
void LocalTransform<Real>::inverse_row(Real* in, int row, Real* plane) {
  if (!periodic_z()) {
    inverse_x_(in, plane + this->real_place(row));
    return;
  }
  inverse_x_(in, scratch_.data());
  if (nx_ % 2 != 0) std::fill_n(&scratch_[2 * static_cast<std::size_t>(nx_)], 2, Real(0));
  const int partner = (nz_ - row) % nz_;
  if (partner == row)
    put_real_together(columns_, scratch_.data(), mode_row(plane, row));
  else
    put_together(columns_, scratch_.data(), mode_row(plane, row), mode_row(plane, partner));
}

template <class Real>
void LocalTransform<Real>::end_inverse(Real* plane) {
  inverse_z_(plane, plane);
}

template class LocalTransform<float>;
template class LocalTransform<double>;

}  // namespace bedload
