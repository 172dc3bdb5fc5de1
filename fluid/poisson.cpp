#include "fluid/poisson.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "fluid/slab_elimination.hpp"

namespace bedload {
namespace {

/// One eigenvalue per stored mode, padding included (there any regular one does).
template <class Real>
std::vector<double> mode_eigenvalues(const PlaneTransform<Real>& transform) {
  std::vector<double> eigenvalue(transform.size(), -4.0);
  for (int row = 0; row < transform.rows(); ++row)
    for (int m = 0; m < transform.modes(); ++m)
      eigenvalue[static_cast<std::size_t>(row) * transform.pitch() + static_cast<std::size_t>(m)] =
          transform.eigenvalue(m, row);
  return eigenvalue;
}

/// d'_j = c_j (own d_j - below d'_j-1) on one spectral row; `d` holds d_j and is overwritten.
template <int parts, class Real>
void eliminate_row(int modes, Real own, Real below, const Real* c, const Real* before,
                   Real* __restrict d) {
  for (int m = 0; m < modes; ++m)
    for (int n = parts * m; n < parts * (m + 1); ++n)
      d[n] = c[m] * (own * d[n] - below * before[n]);
}

/// d'_0 = c_0 own d_0.
template <int parts, class Real>
void eliminate_first_row(int modes, Real own, const Real* c, Real* __restrict d) {
  for (int m = 0; m < modes; ++m)
    for (int n = parts * m; n < parts * (m + 1); ++n) d[n] *= own * c[m];
}

/// sum -= scale * factor * value, one factor per mode.
template <int parts, class Real>
void subtract_product(int modes, Real scale, const Real* factor, const Real* value,
                      Real* __restrict sum) {
  for (int m = 0; m < modes; ++m)
    for (int n = parts * m; n < parts * (m + 1); ++n) sum[n] -= scale * factor[m] * value[n];
}

/// x_j = d'_j - c_j x_j+1; `x` holds x_j+1 and is overwritten.
template <int parts, class Real>
void substitute_row(int modes, const Real* c, const Real* d, Real* __restrict x) {
  for (int m = 0; m < modes; ++m)
    for (int n = parts * m; n < parts * (m + 1); ++n) x[n] = d[n] - c[m] * x[n];
}

}  // namespace

template <class Real>
PoissonSolver<Real>::PoissonSolver(const Grid& grid, const Decomposition& decomposition,
                                   int component)
    : transform_(make_plane_transform<Real>(grid, component, decomposition)),
      reduced_(grid, decomposition, transform_->size(), transform_->parts()),
      of_pressure_(component == pressure_component),
      planes_(decomposition.planes()),
      coupled_below_(!decomposition.at_lower_wall()),
      coupled_above_(!decomposition.at_upper_wall()),
      eigenvalue_(mode_eigenvalues(*transform_)) {
  const std::size_t modes = transform_->size(), planes = static_cast<std::size_t>(planes_);
  const std::size_t values = modes * static_cast<std::size_t>(transform_->parts());
  c_ = AlignedArray<Real>(planes * modes);
  if (coupled_below_) f_ = AlignedArray<Real>(planes * modes);
  eliminated_ = AlignedArray<Real>(planes * values);
  for (AlignedArray<Real>* plane : {&first_, &outside_, &last_, &above_})
    *plane = AlignedArray<Real>(values);
  for (AlignedArray<Real>* plane : {&work_, &excess_, &solution_[0], &solution_[1]})
    *plane = AlignedArray<Real>(transform_->real_size());
  for (int j = 0; j < planes_; ++j)
    rows_.push_back(y_row(grid, component, decomposition.first() + j));
  factors_ = plane_factors(rows_);
  if (of_pressure_) set_shift(0.0);
}

template <class Real>
void PoissonSolver<Real>::set_shift(double shift) {
  const std::size_t pitch = transform_->pitch();
  std::vector<SlabCoupling> coupling(transform_->size());
  const auto mean = std::find(eigenvalue_.begin(), eigenvalue_.end(), 0.0);
  std::optional<std::size_t> open;  // the mode that leaves the pressure's level open
  if (of_pressure_ && mean != eigenvalue_.end())
    open = static_cast<std::size_t>(mean - eigenvalue_.begin());
  std::vector<double> eigenvalue(pitch);
  for (int row = 0; row < transform_->rows(); ++row) {
    const std::size_t first = at(0, row);
    for (std::size_t m = 0; m < pitch; ++m) eigenvalue[m] = eigenvalue_[first + m] - shift;
    eliminate_slab(
        rows_, eigenvalue, open && *open >= first ? *open - first : pitch,
        [&](std::size_t j, const double* c, const double* f) {
          const std::size_t place = at(static_cast<int>(j), row);
          for (std::size_t m = 0; m < pitch; ++m) c_[place + m] = static_cast<Real>(c[m]);
          if (!coupled_below_) return;
          for (std::size_t m = 0; m < pitch; ++m) f_[place + m] = static_cast<Real>(f[m]);
        },
        std::span(coupling).subspan(first, pitch));
  }
  reduced_.factorise(coupling, open);
}

template <class Real>
void PoissonSolver<Real>::eliminate(int j, double scale) {
  transform_->forward_plane(work_.data());
  transform_->parts() == 2 ? eliminate_rows<2>(j, scale) : eliminate_rows<1>(j, scale);
}

template <class Real>
template <int parts>
void PoissonSolver<Real>::eliminate_rows(int j, double scale) {
  const int modes = transform_->modes();
  const PlaneFactors& factor = factors_[static_cast<std::size_t>(j)];
  const Real own = static_cast<Real>(factor.own * scale * transform_->normalisation());
  const Real below = static_cast<Real>(factor.before);
  for (int kz = 0; kz < transform_->rows(); ++kz) {
    Real* row = &eliminated_[parts * at(j, kz)];
    transform_->forward_row(work_.data(), kz, row);
    if (j == 0)
      eliminate_first_row<parts>(modes, own, &c_[at(0, kz)], row);
    else
      eliminate_row<parts>(modes, own, below, &c_[at(j, kz)], &eliminated_[parts * at(j - 1, kz)],
                           row);
    if (!coupled_below_) continue;
    // g = d'_0 - sum t_j f_j-1 d'_j over all planes but the last
    Real* first = &first_[parts * at(0, kz)];
    if (j == 0) std::fill_n(first, parts * modes, Real(0));
    if (j == planes_ - 1) continue;
    if (j == 0)
      std::copy_n(row, parts * modes, first);
    else
      subtract_product<parts>(modes, static_cast<Real>(factor.first), &f_[at(j - 1, kz)], row,
                              first);
  }
}

template <class Real>
void PoissonSolver<Real>::couple() {
  if (coupled_above_ && !of_pressure_) {
    std::fill_n(outside_.data(), outside_.size(), Real(0));
  } else if (coupled_above_) {
    const Real scale = static_cast<Real>(transform_->normalisation());
    const std::size_t parts = static_cast<std::size_t>(transform_->parts());
    transform_->forward_plane(excess_.data());
    for (int kz = 0; kz < transform_->rows(); ++kz) {
      Real* row = &outside_[parts * at(0, kz)];
      transform_->forward_row(excess_.data(), kz, row);
      for (int n = 0; n < transform_->parts() * transform_->modes(); ++n) row[n] *= scale;
    }
  }
  const std::size_t top = static_cast<std::size_t>(transform_->parts()) * at(planes_ - 1, 0);
  reduced_.solve({.last = &eliminated_[top], .first = first_.data(), .excess = outside_.data()},
                 {.below = outside_.data(), .last = last_.data(), .above = above_.data()});
}

template <class Real>
void PoissonSolver<Real>::substitute(int j) {
  transform_->parts() == 2 ? substitute_rows<2>(j) : substitute_rows<1>(j);
  transform_->inverse_plane(solution_[j & 1].data());
  const int nx = transform_->nx();
  for (int k = 0; k < nz() + (gives_to_front() ? 1 : 0); ++k) {
    Real* row = real_row(solution_[j & 1], k);
    row[nx] = transform_->periodic_x() ? row[0] : row[nx - 1];
  }
}

template <class Real>
template <int parts>
void PoissonSolver<Real>::substitute_rows(int j) {
  const int modes = transform_->modes();
  for (int kz = 0; kz < transform_->rows(); ++kz) {
    Real* row = &(j == planes_ ? above_ : last_)[parts * at(0, kz)];
    if (j < planes_ - 1) {
      substitute_row<parts>(modes, &c_[at(j, kz)], &eliminated_[parts * at(j, kz)], row);
      if (coupled_below_)
        subtract_product<parts>(modes, Real(1), &f_[at(j, kz)], &outside_[parts * at(0, kz)], row);
    }
    transform_->inverse_row(row, kz, solution_[j & 1].data());
  }
}

template <class Real>
std::size_t PoissonSolver<Real>::bytes() const {
  std::size_t values = 0;
  for (const AlignedArray<Real>* array : {&c_, &f_, &eliminated_, &first_, &outside_, &last_,
                                          &above_, &work_, &excess_, &solution_[0], &solution_[1]})
    values += array->size();
  return sizeof(Real) * values + transform_->bytes();
}

template class PoissonSolver<float>;
template class PoissonSolver<double>;

}  // namespace bedload
