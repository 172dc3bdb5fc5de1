#include "fluid/poisson/poisson.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "fluid/kernels/independent_loop.hpp"
#include "fluid/kernels/past_caches.hpp"
#include "fluid/kernels/prefetch.hpp"
#include "fluid/kernels/simd.hpp"

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

/// d'_j = c_j (own d_j - below d'_j-1) on one spectral row of `modes` modes, padding included.
/// Written to `now` and, where there is a `kept`, past the caches to that as well.
template <int parts, class Real>
void eliminate_modes(std::size_t modes, Real own, Real below, const Real* c, const Real* d,
                     const Real* before, Real* now, Real* kept) {
  for (std::size_t m = 0; m < modes; m += simd_width) {
    const auto weight = repeated<parts>(load(c + m));
    const std::size_t n = parts * m;
    const auto next = weight * (own * load_as(weight, d + n) - below * load_as(weight, before + n));
    store(now + n, next);
    if (kept) store_past_caches(kept + n, next);
  }
}

/// sum -= scale * factor * value, one factor per mode, where there are factors.
template <int parts, class Real>
void subtract_product(int modes, Real scale, const typename EndModes<Real>::Part& factor,
                      const Real* value, Real* __restrict sum) {
  const auto subtract = [=](std::size_t begin, std::size_t end, const Real* factors) {
    std::size_t m = begin;
    for (; m + simd_width <= end; m += simd_width) {
      const auto weight = repeated<parts>(scale * load(factors + (m - begin)));
      auto left = load_as(weight, sum + parts * m);
      left -= weight * load_as(weight, value + parts * m);
      store(sum + parts * m, left);
    }
    for (; m < end; ++m)
      for (std::size_t n = parts * m; n < parts * (m + 1); ++n)
        sum[n] -= scale * factors[m - begin] * value[n];
  };
  subtract(0, factor.low, factor.values);
  subtract(factor.high, static_cast<std::size_t>(modes), factor.values + factor.low);
}

/// Asks for what subtract_product is going to read.
template <int parts, class Real>
void ask_for_product(int modes, const typename EndModes<Real>::Part& factor, const Real* value) {
  const std::size_t end = static_cast<std::size_t>(modes);
  ask_for(factor.values, factor.low + end - factor.high);
  ask_for(value, parts * factor.low);
  ask_for(value + parts * factor.high, parts * (end - factor.high));
}

/// x_j = d'_j - c_j x_j+1; `x` holds x_j+1 and is overwritten.
template <int parts, class Real>
void substitute_modes(int modes, const Real* c, const Real* d, Real* __restrict x) {
  for (int m = 0; m < modes; ++m)
    for (int n = parts * m; n < parts * (m + 1); ++n) x[n] = d[n] - c[m] * x[n];
}

}  // namespace

template <class Real>
PoissonSolver<Real>::PoissonSolver(const Grid& grid, const Decomposition& decomposition,
                                   int component, int planes_at_once, std::size_t stays_in_caches)
    : transform_(make_plane_transform<Real>(grid, component, decomposition)),
      reduced_(grid, decomposition, transform_->size(), transform_->parts()),
      of_pressure_(component == pressure_component),
      planes_(decomposition.planes()),
      coupled_below_(!decomposition.at_lower_wall()),
      coupled_above_(!decomposition.at_upper_wall()),
      eigenvalue_(mode_eigenvalues(*transform_)),
      kept_systems_(grid.stretched() ? 1 : 3) {  // on stretched y they are as large as a field
  const std::size_t modes = transform_->size(), planes = static_cast<std::size_t>(planes_);
  const std::size_t values = modes * static_cast<std::size_t>(transform_->parts());
  eliminated_ = AlignedArray<Real>(planes * values);
  past_caches_ = planes * values * sizeof(Real) > stays_in_caches;
  arriving_ =
      AlignedArray<Real>(transform_->pitch() * static_cast<std::size_t>(transform_->parts()));
  for (AlignedArray<Real>* plane : {&first_, &outside_, &last_, &above_})
    *plane = AlignedArray<Real>(values);
  for (int n = 0; n <= planes_at_once; ++n)
    real_planes_.push_back(AlignedArray<Real>(transform_->real_size()));
  excess_ = AlignedArray<Real>(transform_->real_size());
  for (int j = 0; j < planes_; ++j)
    rows_.push_back(y_row(grid, component, decomposition.first() + j));
  factors_ = plane_factors(rows_);
  if (of_pressure_) set_shift(0.0);
}

template <class Real>
void PoissonSolver<Real>::set_shift(double shift) {
  for (std::size_t n = 0; n < systems_.size(); ++n)
    if (systems_[n].shift == shift) {
      system_ = n;
      return;
    }
  if (systems_.size() < kept_systems_) {
    system_ = systems_.size();
    systems_.push_back({});
  } else {
    system_ = (system_ + 1) % kept_systems_;
    systems_[system_] = {};  // its memory first
  }
  systems_[system_] = make_system(shift);
}

template <class Real>
typename PoissonSolver<Real>::System PoissonSolver<Real>::make_system(double shift) {
  // What the plane below a slab has died down to is left out: below round-off of what it is added
  // to, and before it becomes a subnormal number, which processors are slow with.
  constexpr Real negligible = Real(1e-4) * std::numeric_limits<Real>::epsilon();
  const std::size_t pitch = transform_->pitch(), planes = static_cast<std::size_t>(planes_);
  System system{
      .shift = shift,
      .c = {transform_->rows(), planes_, pitch},
      .f = coupled_below_ ? EndModes<Real>(transform_->rows(), planes_) : EndModes<Real>(),
      .coupling = {}};
  std::vector<SlabCoupling> coupling(transform_->size());
  const auto mean = std::find(eigenvalue_.begin(), eigenvalue_.end(), 0.0);
  std::optional<std::size_t> open;  // the mode that leaves the pressure's level open
  if (of_pressure_ && mean != eigenvalue_.end())
    open = static_cast<std::size_t>(mean - eigenvalue_.begin());
  std::vector<double> eigenvalue(pitch);
  std::vector<Real> all_c(planes * pitch), all_f(planes * pitch);
  for (int row = 0; row < transform_->rows(); ++row) {
    const std::size_t first = at(0, row);
    for (std::size_t m = 0; m < pitch; ++m) eigenvalue[m] = eigenvalue_[first + m] - shift;
    const std::size_t open_here = open && *open >= first ? *open - first : pitch;
    const auto store = [&](std::size_t n, const double* c, const double* f) {
      for (std::size_t m = 0; m < pitch; ++m) {
        all_c[n * pitch + m] = static_cast<Real>(c[m]);
        all_f[n * pitch + m] = static_cast<Real>(f[m]);
      }
    };
    eliminate_slab(rows_, eigenvalue, open_here, store, std::span(coupling).subspan(first, pitch));
    system.c.set_row(row, all_c);
    if (!coupled_below_) continue;
    const auto f = [&](std::size_t j, std::size_t m) { return all_f[j * pitch + m]; };
    // In groups of eight, so that vectorised loops leave nothing over.
    const std::size_t modes = static_cast<std::size_t>(transform_->modes());
    const auto counts = [&](std::size_t j, std::size_t m) {
      const std::size_t begin = m / 8 * 8, last = std::min(begin + 7, modes - 1);
      return std::max(std::abs(f(j, begin)), std::abs(f(j, last))) > negligible;
    };
    system.f.set_row(row, modes, counts, f);
  }
  system.coupling = reduced_.factorise(coupling, open);
  return system;
}

template <class Real>
void PoissonSolver<Real>::eliminate(int first, int end, double scale) {
  for (int j = first; j < end; ++j) {
    transform_->begin_forward(real_plane(j).data());
    if (!transform_->exchanges()) continue;
    end_elimination();
    begun_ = Begun{j, scale};
  }
  if (transform_->exchanges()) return;
  transform_->end_forward();
  eliminate_rows(first, end, scale);
}

/// Of the plane that is under way, if one is.
template <class Real>
void PoissonSolver<Real>::end_elimination() {
  if (!begun_) return;
  const auto [j, scale] = *begun_;
  begun_.reset();
  transform_->end_forward();
  eliminate_rows(j, j + 1, scale);
}

template <class Real>
void PoissonSolver<Real>::eliminate_rows(int first, int end, double scale) {
  for (int kz = 0; kz < transform_->rows(); ++kz)
    for (int j = first; j < end; ++j) {
      const bool last = j + 1 == end;
      ask_to_eliminate(last ? first : j + 1, last ? kz + 1 : kz);
      transform_->parts() == 2 ? eliminate_row<2>(j, kz, scale) : eliminate_row<1>(j, kz, scale);
    }
}

/// Asks for what eliminate_row() is going to read and write, if there is such a row.
template <class Real>
void PoissonSolver<Real>::ask_to_eliminate(int j, int kz) {
  if (kz == transform_->rows()) return;
  const std::size_t parts = static_cast<std::size_t>(transform_->parts());
  if (!past_caches_) ask_to_write(&eliminated_[parts * at(j, kz)], parts * transform_->pitch());
  systems_[system_].c.ask_for_row(j, kz);
}

template <class Real>
template <int parts>
void PoissonSolver<Real>::eliminate_row(int j, int kz, double scale) {
  const int modes = transform_->modes();
  System& system = systems_[system_];
  const PlaneFactors& factor = factors_[static_cast<std::size_t>(j)];
  const Real own = static_cast<Real>(factor.own * scale * transform_->normalisation());
  const Real before = static_cast<Real>(factor.before);
  // The sweep's latest d' is in last_, too, if the others are written past the caches.
  Real *sweep = &last_[parts * at(0, kz)], *kept = &eliminated_[parts * at(j, kz)];
  Real* row = past_caches_ ? sweep : kept;
  if (j == 0) std::fill_n(sweep, parts * transform_->pitch(), Real(0));
  const Real* below = past_caches_ || j == 0 ? sweep : &eliminated_[parts * at(j - 1, kz)];
  transform_->forward_row(real_plane(j).data(), kz, arriving_.data());
  eliminate_modes<parts>(transform_->pitch(), own, before, system.c.row(j, kz), arriving_.data(),
                         below, row, past_caches_ ? kept : nullptr);
  if (!coupled_below_) return;
  if (j > 0 && kz + 1 < transform_->rows())
    ask_for_product<parts, Real>(modes, system.f.part(j - 1, kz + 1),
                                 &first_[parts * at(0, kz + 1)]);
  // g = d'_0 - sum t_j f_j-1 d'_j over all planes but the last
  Real* first = &first_[parts * at(0, kz)];
  if (j == 0) std::fill_n(first, parts * modes, Real(0));
  if (j == planes_ - 1) return;
  if (j == 0)
    std::copy_n(row, parts * modes, first);
  else
    subtract_product<parts>(modes, static_cast<Real>(factor.first), system.f.part(j - 1, kz), row,
                            first);
}

template <class Real>
void PoissonSolver<Real>::couple() {
  end_elimination();
  if (coupled_above_ && !of_pressure_) {
    std::fill_n(outside_.data(), outside_.size(), Real(0));
  } else if (coupled_above_) {
    const Real scale = static_cast<Real>(transform_->normalisation());
    const std::size_t parts = static_cast<std::size_t>(transform_->parts());
    transform_->begin_forward(excess_.data());
    transform_->end_forward();
    for (int kz = 0; kz < transform_->rows(); ++kz) {
      Real* row = &outside_[parts * at(0, kz)];
      transform_->forward_row(excess_.data(), kz, row);
      for (int n = 0; n < transform_->parts() * transform_->modes(); ++n) row[n] *= scale;
    }
  }
  const std::size_t top = static_cast<std::size_t>(transform_->parts()) * at(planes_ - 1, 0);
  reduced_.solve(systems_[system_].coupling,
                 {.last = &eliminated_[top], .first = first_.data(), .excess = outside_.data()},
                 {.below = outside_.data(), .last = last_.data(), .above = above_.data()});
}

template <class Real>
void PoissonSolver<Real>::substitute(int first, int end) {
  if (!transform_->exchanges()) substitute_rows(first, end);
  for (int j = end - 1; j >= first; --j) {
    if (transform_->exchanges()) {
      if (!begun_) begin_substitution(j);
      begun_.reset();
      if (j > 0) begin_substitution(j - 1);
    }
    end_substitution(j);
  }
}

template <class Real>
void PoissonSolver<Real>::begin_substitution(int j) {
  substitute_rows(j, j + 1);
  transform_->begin_inverse();
  begun_ = Begun{j, 1.0};
}

template <class Real>
void PoissonSolver<Real>::end_substitution(int j) {
  transform_->end_inverse(real_plane(j).data());
  const int nx = transform_->nx();
  for (int k = 0; k < nz() + (gives_to_front() ? 1 : 0); ++k) {
    Real* row = real_row(real_plane(j), k);
    row[nx] = transform_->periodic_x() ? row[0] : row[nx - 1];
  }
}

template <class Real>
void PoissonSolver<Real>::substitute_rows(int first, int end) {
  for (int kz = 0; kz < transform_->rows(); ++kz)
    for (int j = end - 1; j >= first; --j) {
      const bool last = j == first;
      ask_to_substitute(last ? end - 1 : j - 1, last ? kz + 1 : kz);
      transform_->parts() == 2 ? substitute_row<2>(j, kz) : substitute_row<1>(j, kz);
    }
}

/// Asks for what substitute_row() is going to read, if there is such a row.
template <class Real>
void PoissonSolver<Real>::ask_to_substitute(int j, int kz) {
  if (kz == transform_->rows() || j >= planes_ - 1) return;
  const std::size_t parts = static_cast<std::size_t>(transform_->parts());
  const System& system = systems_[system_];
  ask_for(&eliminated_[parts * at(j, kz)], parts * transform_->pitch());
  system.c.ask_for_row(j, kz);
  if (!coupled_below_) return;
  const Real* outside = &outside_[parts * at(0, kz)];
  if (parts == 2)
    ask_for_product<2, Real>(transform_->modes(), system.f.part(j, kz), outside);
  else
    ask_for_product<1, Real>(transform_->modes(), system.f.part(j, kz), outside);
}

template <class Real>
template <int parts>
void PoissonSolver<Real>::substitute_row(int j, int kz) {
  const int modes = transform_->modes();
  System& system = systems_[system_];
  Real* row = &(j == planes_ ? above_ : last_)[parts * at(0, kz)];
  if (j < planes_ - 1) {
    substitute_modes<parts>(modes, system.c.row(j, kz), &eliminated_[parts * at(j, kz)], row);
    if (coupled_below_)
      subtract_product<parts>(modes, Real(1), system.f.part(j, kz), &outside_[parts * at(0, kz)],
                              row);
  }
  transform_->inverse_row(row, kz, real_plane(j).data());
}

template class PoissonSolver<float>;
template class PoissonSolver<double>;

}  // namespace bedload
