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
  for (int kz = 0; kz < transform.rows(); ++kz)
    for (int kx = 0; kx < transform.nx(); ++kx)
      eigenvalue[static_cast<std::size_t>(kz) * transform.pitch() + static_cast<std::size_t>(kx)] =
          transform.eigenvalue(kx, kz);
  return eigenvalue;
}

/// d'_j = c_j (scale d_j - d'_j-1) on one spectral row; `d` holds d_j and is overwritten.
template <class Real>
void eliminate_row(int modes, Real scale, const Real* c, const Real* before, Real* __restrict d) {
  for (int m = 0; m < modes; ++m) {
    d[2 * m] = c[m] * (scale * d[2 * m] - before[2 * m]);
    d[2 * m + 1] = c[m] * (scale * d[2 * m + 1] - before[2 * m + 1]);
  }
}

/// d'_0 = c_0 scale d_0.
template <class Real>
void eliminate_first_row(int modes, Real scale, const Real* c, Real* __restrict d) {
  for (int m = 0; m < modes; ++m) {
    d[2 * m] *= scale * c[m];
    d[2 * m + 1] *= scale * c[m];
  }
}

/// sum += factor * value, factor one real number per mode.
template <class Real>
void subtract_product(int modes, const Real* factor, const Real* value, Real* __restrict sum) {
  for (int m = 0; m < modes; ++m) {
    sum[2 * m] -= factor[m] * value[2 * m];
    sum[2 * m + 1] -= factor[m] * value[2 * m + 1];
  }
}

/// x_j = d'_j - c_j x_j+1; `x` holds x_j+1 and is overwritten.
template <class Real>
void substitute_row(int modes, const Real* c, const Real* d, Real* __restrict x) {
  for (int m = 0; m < modes; ++m) {
    x[2 * m] = d[2 * m] - c[m] * x[2 * m];
    x[2 * m + 1] = d[2 * m + 1] - c[m] * x[2 * m + 1];
  }
}

template <class Real>
Real* reals(std::complex<Real>* z) {
  return reinterpret_cast<Real*>(z);
}

}  // namespace

template <class Real>
PoissonSolver<Real>::PoissonSolver(const Grid& grid, const Decomposition& decomposition)
    : transform_(grid, decomposition.comm()),
      reduced_(grid, decomposition, mode_eigenvalues(transform_)),
      planes_(decomposition.planes()),
      coupled_below_(!decomposition.at_lower_wall()),
      coupled_above_(!decomposition.at_upper_wall()) {
  const std::size_t size = transform_.size(), planes = static_cast<std::size_t>(planes_);
  c_ = AlignedArray<Real>(planes * size);
  if (coupled_below_) f_ = AlignedArray<Real>(planes * size);
  eliminated_ = AlignedArray<Complex>(planes * size);
  first_ = AlignedArray<Complex>(size);
  outside_ = AlignedArray<Complex>(size);
  last_ = AlignedArray<Complex>(size);
  above_ = AlignedArray<Complex>(size);
  for (AlignedArray<Real>* plane : {&work_, &excess_, &solution_[0], &solution_[1]})
    *plane = AlignedArray<Real>(transform_.real_size());

  const SlabEnds ends{.wall_below = !coupled_below_, .wall_above = !coupled_above_};
  for (int kz = 0; kz < transform_.rows(); ++kz)
    for (int kx = 0; kx < transform_.nx(); ++kx) {
      const bool singular = kx == 0 && kz == 0 && ends.wall_below && ends.wall_above;
      eliminate_slab(transform_.eigenvalue(kx, kz), planes_, ends, singular,
                     [&](int j, double c, double f) {
                       const std::size_t n = at(j, kz) + static_cast<std::size_t>(kx);
                       c_[n] = static_cast<Real>(c);
                       if (coupled_below_) f_[n] = static_cast<Real>(f);
                     });
    }
}

template <class Real>
void PoissonSolver<Real>::eliminate(int j) {
  const int modes = transform_.nx();
  const Real scale = static_cast<Real>(transform_.normalisation());
  transform_.forward_z(work_.data());
  for (int kz = 0; kz < transform_.rows(); ++kz) {
    Complex* row = &eliminated_[at(j, kz)];
    transform_.forward_row(work_.data(), kz, row);
    if (j == 0) {
      eliminate_first_row(modes, scale, &c_[at(0, kz)], reals(row));
    } else {
      const Complex* before = &eliminated_[at(j - 1, kz)];
      eliminate_row(modes, scale, &c_[at(j, kz)], reinterpret_cast<const Real*>(before),
                    reals(row));
    }
    if (!coupled_below_) continue;
    Complex* first = &first_[at(0, kz)];  // g = d'_0 - sum f_j-1 d'_j over all planes but the last
    if (j == 0) std::fill_n(first, modes, Complex{});
    if (j == planes_ - 1) continue;
    if (j == 0)
      std::copy_n(row, modes, first);
    else
      subtract_product(modes, &f_[at(j - 1, kz)], reals(row), reals(first));
  }
}

template <class Real>
void PoissonSolver<Real>::couple() {
  if (coupled_above_) {
    const Real scale = static_cast<Real>(transform_.normalisation());
    transform_.forward_z(excess_.data());
    for (int kz = 0; kz < transform_.rows(); ++kz) {
      Complex* row = &outside_[at(0, kz)];
      transform_.forward_row(excess_.data(), kz, row);
      for (int m = 0; m < transform_.nx(); ++m) row[m] *= scale;
    }
  }
  reduced_.solve(
      {.last = &eliminated_[at(planes_ - 1, 0)], .first = first_.data(), .excess = outside_.data()},
      {.below = outside_.data(), .last = last_.data(), .above = above_.data()});
}

template <class Real>
void PoissonSolver<Real>::substitute(int j) {
  const int modes = transform_.nx();
  Real* plane = solution_[j & 1].data();
  for (int kz = 0; kz < transform_.rows(); ++kz) {
    Complex* row = j == planes_ ? &above_[at(0, kz)] : &last_[at(0, kz)];
    if (j < planes_ - 1) {
      const Complex* d = &eliminated_[at(j, kz)];
      substitute_row(modes, &c_[at(j, kz)], reinterpret_cast<const Real*>(d), reals(row));
      if (coupled_below_)
        subtract_product(modes, &f_[at(j, kz)], reals(&outside_[at(0, kz)]), reals(row));
    }
    transform_.inverse_row(row, kz, plane);
  }
  transform_.inverse_z(plane);
  const std::size_t nx = static_cast<std::size_t>(transform_.nx());
  for (int k = 0; k < transform_.nz(); ++k) {
    Real* row = real_row(solution_[j & 1], k);
    row[nx] = row[0];
  }
}

template <class Real>
std::size_t PoissonSolver<Real>::bytes() const {
  const std::size_t reals = c_.size() + f_.size() + work_.size() + excess_.size() +
                            solution_[0].size() + solution_[1].size();
  const std::size_t complexes =
      eliminated_.size() + first_.size() + outside_.size() + last_.size() + above_.size();
  return sizeof(Real) * (reals + 2 * complexes);
}

template class PoissonSolver<float>;
template class PoissonSolver<double>;

}  // namespace bedload
