#include "fluid/poisson.hpp"

#include <algorithm>
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

/// d'_j = c_j (scale d_j - d'_j-1) on one spectral row; `d` holds d_j and is overwritten.
template <int parts, class Real>
void eliminate_row(int modes, Real scale, const Real* c, const Real* before, Real* __restrict d) {
  for (int m = 0; m < modes; ++m)
    for (int n = parts * m; n < parts * (m + 1); ++n) d[n] = c[m] * (scale * d[n] - before[n]);
}

/// d'_0 = c_0 scale d_0.
template <int parts, class Real>
void eliminate_first_row(int modes, Real scale, const Real* c, Real* __restrict d) {
  for (int m = 0; m < modes; ++m)
    for (int n = parts * m; n < parts * (m + 1); ++n) d[n] *= scale * c[m];
}

/// sum -= factor * value, one factor per mode.
template <int parts, class Real>
void subtract_product(int modes, const Real* factor, const Real* value, Real* __restrict sum) {
  for (int m = 0; m < modes; ++m)
    for (int n = parts * m; n < parts * (m + 1); ++n) sum[n] -= factor[m] * value[n];
}

/// x_j = d'_j - c_j x_j+1; `x` holds x_j+1 and is overwritten.
template <int parts, class Real>
void substitute_row(int modes, const Real* c, const Real* d, Real* __restrict x) {
  for (int m = 0; m < modes; ++m)
    for (int n = parts * m; n < parts * (m + 1); ++n) x[n] = d[n] - c[m] * x[n];
}

}  // namespace

template <class Real>
PoissonSolver<Real>::PoissonSolver(const Grid& grid, const Decomposition& decomposition)
    : transform_(make_plane_transform<Real>(grid, pressure_component, decomposition)),
      reduced_(grid, decomposition, mode_eigenvalues(*transform_), transform_->parts()),
      planes_(decomposition.planes()),
      coupled_below_(!decomposition.at_lower_wall()),
      coupled_above_(!decomposition.at_upper_wall()) {
  const std::size_t modes = transform_->size(), planes = static_cast<std::size_t>(planes_);
  const std::size_t values = modes * static_cast<std::size_t>(transform_->parts());
  c_ = AlignedArray<Real>(planes * modes);
  if (coupled_below_) f_ = AlignedArray<Real>(planes * modes);
  eliminated_ = AlignedArray<Real>(planes * values);
  for (AlignedArray<Real>* plane : {&first_, &outside_, &last_, &above_})
    *plane = AlignedArray<Real>(values);
  for (AlignedArray<Real>* plane : {&work_, &excess_, &solution_[0], &solution_[1]})
    *plane = AlignedArray<Real>(transform_->real_size());

  const SlabEnds ends{.wall_below = !coupled_below_, .wall_above = !coupled_above_};
  for (int row = 0; row < transform_->rows(); ++row)
    for (int m = 0; m < transform_->modes(); ++m) {
      const double eigenvalue = transform_->eigenvalue(m, row);
      const bool singular = eigenvalue == 0.0 && ends.wall_below && ends.wall_above;
      eliminate_slab(eigenvalue, planes_, ends, singular, [&](int j, double c, double f) {
        const std::size_t n = at(j, row) + static_cast<std::size_t>(m);
        c_[n] = static_cast<Real>(c);
        if (coupled_below_) f_[n] = static_cast<Real>(f);
      });
    }
}

template <class Real>
void PoissonSolver<Real>::eliminate(int j) {
  transform_->forward_plane(work_.data());
  transform_->parts() == 2 ? eliminate_rows<2>(j) : eliminate_rows<1>(j);
}

template <class Real>
template <int parts>
void PoissonSolver<Real>::eliminate_rows(int j) {
  const int modes = transform_->modes();
  const Real scale = static_cast<Real>(transform_->normalisation());
  for (int kz = 0; kz < transform_->rows(); ++kz) {
    Real* row = &eliminated_[parts * at(j, kz)];
    transform_->forward_row(work_.data(), kz, row);
    if (j == 0)
      eliminate_first_row<parts>(modes, scale, &c_[at(0, kz)], row);
    else
      eliminate_row<parts>(modes, scale, &c_[at(j, kz)], &eliminated_[parts * at(j - 1, kz)], row);
    if (!coupled_below_) continue;
    Real* first = &first_[parts * at(0, kz)];  // g = d'_0 - sum f_j-1 d'_j over all but the last
    if (j == 0) std::fill_n(first, parts * modes, Real(0));
    if (j == planes_ - 1) continue;
    if (j == 0)
      std::copy_n(row, parts * modes, first);
    else
      subtract_product<parts>(modes, &f_[at(j - 1, kz)], row, first);
  }
}

template <class Real>
void PoissonSolver<Real>::couple() {
  if (coupled_above_) {
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
        subtract_product<parts>(modes, &f_[at(j, kz)], &outside_[parts * at(0, kz)], row);
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
