#include "fluid/poisson/reduced_system.hpp"

#include <algorithm>

#include "fluid/kernels/independent_loop.hpp"
#include "fluid/poisson/slab_elimination.hpp"

namespace bedload {

template <class Real>
ReducedSystem<Real>::ReducedSystem(const Grid& grid, const Decomposition& decomposition,
                                   std::size_t modes, int parts)
    : comm_(decomposition.y_comm()),
      rank_(decomposition.y_part()),
      ranks_(decomposition.y_parts()),
      cyclic_(grid.periodic(1)),
      modes_(modes),
      parts_(static_cast<std::size_t>(parts)) {
  const std::size_t slabs = static_cast<std::size_t>(ranks_), own = own_share();
  values_.resize(slabs);
  to_owner_.resize(3 * parts_ * modes_);
  at_owner_.resize(3 * parts_ * own * slabs);
  count_messages();
}

template <class Real>
typename ReducedSystem<Real>::Factors ReducedSystem<Real>::factorise(
    std::span<const SlabCoupling> own, std::optional<std::size_t> open) const {
  const std::size_t slabs = static_cast<std::size_t>(ranks_), share = own_share();
  constexpr std::size_t numbers = sizeof(SlabCoupling) / sizeof(double);
  const auto in_numbers = [&](const std::vector<int>& values) {  // from 3 parts to these
    std::vector<int> counts;
    counts.reserve(values.size());
    for (const int n : values)
      counts.push_back(n / static_cast<int>(3 * parts_) * static_cast<int>(numbers));
    return counts;
  };
  std::vector<SlabCoupling> all(share * slabs);
  MPI_Alltoallv(own.data(), in_numbers(rank_counts_).data(), in_numbers(rank_offsets_).data(),
                MPI_DOUBLE, all.data(), in_numbers(owner_counts_).data(),
                in_numbers(owner_offsets_).data(), MPI_DOUBLE, comm_);
  const std::vector<double> none(share);
  Factors factors{std::vector<Row>(slabs, {none, none, none, none, none, none, none, none}), none};
  std::vector<Row>& rows = factors.rows;
  for (std::size_t m = 0; m < share; ++m) {
    for (std::size_t r = 0; r < slabs; ++r) {
      const SlabCoupling& slab = all[r * share + m];
      rows[r].c[m] = slab.c;
      rows[r].f[m] = slab.f;
      rows[r].alpha[m] = slab.alpha;
      rows[r].beta[m] = slab.beta;
    }
    factorise_mode(factors, m);
    if (open && share_begin(rank_) + m == *open) factors.inverse_last[m] = 0.0;
  }
  return factors;
}

/// Eliminates Y: row r reads lower X_r-1 + diagonal X_r + upper X_r+1 = right-hand side with
///   lower = f_r,  diagonal = 1 + c_r alpha_r+1,  upper = c_r beta_r+1,
/// then writes X_r = y_r - response_r X_last, which closes a cyclic system as well as an open one.
template <class Real>
void ReducedSystem<Real>::factorise_mode(Factors& factors, std::size_t m) const {
  const std::size_t slabs = static_cast<std::size_t>(ranks_), last = slabs - 1;
  std::vector<Row>& row = factors.rows;
  double& inverse_last = factors.inverse_last[m];
  const auto diagonal = [&](std::size_t r) {
    return 1.0 + row[r].c[m] * row[(r + 1) % slabs].alpha[m];
  };
  const auto upper = [&](std::size_t r) { return row[r].c[m] * row[(r + 1) % slabs].beta[m]; };
  if (slabs == 1) {
    row[0].lower[m] = row[0].f[m];
    inverse_last = 1.0 / (row[0].f[m] + diagonal(0) + upper(0));
    return;
  }
  for (std::size_t r = 0; r < slabs; ++r) {
    row[r].lower[m] = row[r].f[m];
    const double before = r > 0 ? row[r - 1].upper[m] : 0.0;
    const double response_before = r > 0 ? row[r - 1].response[m] : -1.0;
    if (r == last) break;
    row[r].inverse_pivot[m] = 1.0 / (diagonal(r) - row[r].lower[m] * before);
    row[r].upper[m] = upper(r) * row[r].inverse_pivot[m];
    row[r].response[m] = -row[r].lower[m] * response_before * row[r].inverse_pivot[m];
  }
  row[last - 1].response[m] += row[last - 1].upper[m];
  for (std::size_t r = last - 1; r-- > 0;)
    row[r].response[m] -= row[r].upper[m] * row[r + 1].response[m];
  row[last].upper[m] = upper(last);
  inverse_last = 1.0 / (diagonal(last) - row[last].lower[m] * row[last - 1].response[m] -
                        row[last].upper[m] * row[0].response[m]);
}

namespace {

/// each(mode, part) for some modes' parts, a loop that compilers can vectorise.
template <int parts, class Each>
[[gnu::always_inline]] inline void for_each_part(std::size_t modes, Each each) {
  BEDLOAD_INDEPENDENT_LOOP
  for (std::size_t m = 0; m < modes; ++m)
    for (std::size_t n = parts * m; n < parts * (m + 1); ++n) each(m, n);
}

}  // namespace

/// X of `count` modes from `begin` on, all slabs, from values_ into values_.
template <class Real>
template <int parts>
void ReducedSystem<Real>::solve_modes(const Factors& factors, std::size_t begin,
                                      std::size_t count) {
  const std::size_t slabs = static_cast<std::size_t>(ranks_), last = slabs - 1;
  const std::vector<Row>& rows = factors.rows;
  for (std::size_t r = 0; r < slabs; ++r) {
    Values& own = values_[r];
    const Values &below = values_[(r + last) % slabs], &above = values_[(r + 1) % slabs];
    const double *f = &rows[r].f[begin], *c = &rows[r].c[begin];
    const double* alpha = &rows[(r + 1) % slabs].alpha[begin];
    for_each_part<parts>(count, [&](std::size_t m, std::size_t n) {  // the right-hand side
      own.x[n] =
          own.last[n] - f[m] * below.excess[n] - c[m] * (above.first[n] + alpha[m] * own.excess[n]);
    });
  }
  Values& end = values_[last];
  const double* inverse_last = &factors.inverse_last[begin];
  if (slabs == 1) {
    for_each_part<parts>(count, [&](std::size_t m, std::size_t n) { end.x[n] *= inverse_last[m]; });
    return;
  }
  for (std::size_t r = 0; r < last; ++r) {
    Values& own = values_[r];
    const Values& below = values_[r > 0 ? r - 1 : 0];
    const double *lower = &rows[r].lower[begin], *inverse = &rows[r].inverse_pivot[begin];
    const double coupled = r > 0 ? 1.0 : 0.0;
    for_each_part<parts>(count, [&](std::size_t m, std::size_t n) {
      own.x[n] = (own.x[n] - coupled * lower[m] * below.x[n]) * inverse[m];
    });
  }
  for (std::size_t r = last - 1; r-- > 0;) {
    Values& own = values_[r];
    const double *upper = &rows[r].upper[begin], *above = values_[r + 1].x.data();
    for_each_part<parts>(count,
                         [&](std::size_t m, std::size_t n) { own.x[n] -= upper[m] * above[n]; });
  }
  const double *lower = &rows[last].lower[begin], *upper = &rows[last].upper[begin];
  const double *below = values_[last - 1].x.data(), *lowest = values_[0].x.data();
  for_each_part<parts>(count, [&](std::size_t m, std::size_t n) {
    end.x[n] = inverse_last[m] * (end.x[n] - lower[m] * below[n] - upper[m] * lowest[n]);
  });
  for (std::size_t r = 0; r < last; ++r) {
    Values& own = values_[r];
    const double* response = &rows[r].response[begin];
    for_each_part<parts>(count,
                         [&](std::size_t m, std::size_t n) { own.x[n] -= response[m] * end.x[n]; });
  }
}

template <class Real>
void ReducedSystem<Real>::solve(const Factors& factors, const Known& known, const Wanted& wanted) {
  const std::vector<Row>& rows = factors.rows;
  const bool lowest = !cyclic_ && rank_ == 0, highest = !cyclic_ && rank_ == ranks_ - 1;
  for (int q = 0; q < ranks_; ++q) {
    const std::size_t begin = parts_ * share_begin(q);
    const std::size_t count = parts_ * share_begin(q + 1) - begin;
    Real* out = to_owner_.data() + 3 * begin;
    std::copy_n(known.last + begin, count, out);
    std::copy_n(known.first + begin, count, out + count);
    if (highest)
      std::fill_n(out + 2 * count, count, Real(0));
    else
      std::copy_n(known.excess + begin, count, out + 2 * count);
  }
  const MPI_Datatype type = mpi_type<Real>();
  MPI_Alltoallv(to_owner_.data(), rank_counts_.data(), rank_offsets_.data(), type, at_owner_.data(),
                owner_counts_.data(), owner_offsets_.data(), type, comm_);

  const std::size_t slabs = static_cast<std::size_t>(ranks_), own = parts_ * own_share();
  for (std::size_t begin = 0; begin < own_share(); begin += batch) {
    const std::size_t modes = std::min(batch, own_share() - begin), count = parts_ * modes;
    for (std::size_t r = 0; r < slabs; ++r) {
      const Real* in = at_owner_.data() + 3 * own * r + parts_ * begin;
      Values& slab = values_[r];
      for (std::size_t n = 0; n < count; ++n) slab.last[n] = static_cast<double>(in[n]);
      for (std::size_t n = 0; n < count; ++n) slab.first[n] = static_cast<double>(in[own + n]);
      for (std::size_t n = 0; n < count; ++n) slab.excess[n] = static_cast<double>(in[2 * own + n]);
    }
    parts_ == 2 ? solve_modes<2>(factors, begin, modes) : solve_modes<1>(factors, begin, modes);
    for (std::size_t r = 0; r < slabs; ++r) {
      const std::size_t next = (r + 1) % slabs;
      const Values &slab = values_[r], &below = values_[(r + slabs - 1) % slabs];
      const Values& above = values_[next];
      const double *alpha = &rows[next].alpha[begin], *beta = &rows[next].beta[begin];
      Real* out = at_owner_.data() + 3 * own * r + parts_ * begin;
      for (std::size_t n = 0; n < count; ++n)
        out[n] = static_cast<Real>(below.x[n] + below.excess[n]);
      for (std::size_t n = 0; n < count; ++n) out[own + n] = static_cast<Real>(slab.x[n]);
      for (std::size_t n = 0; n < count; ++n)
        out[2 * own + n] =
            static_cast<Real>(above.first[n] + alpha[n / parts_] * (slab.x[n] + slab.excess[n]) +
                              beta[n / parts_] * above.x[n]);
    }
  }

  MPI_Alltoallv(at_owner_.data(), owner_counts_.data(), owner_offsets_.data(), type,
                to_owner_.data(), rank_counts_.data(), rank_offsets_.data(), type, comm_);
  for (int q = 0; q < ranks_; ++q) {
    const std::size_t begin = parts_ * share_begin(q);
    const std::size_t count = parts_ * share_begin(q + 1) - begin;
    const Real* in = to_owner_.data() + 3 * begin;
    if (!lowest) std::copy_n(in, count, wanted.below + begin);
    std::copy_n(in + count, count, wanted.last + begin);
    if (!highest) std::copy_n(in + 2 * count, count, wanted.above + begin);
  }
}

/// Message lengths: three values per part of a mode each way.
template <class Real>
void ReducedSystem<Real>::count_messages() {
  const std::size_t values = 3 * parts_;
  for (int r = 0; r < ranks_; ++r) {
    const std::size_t share = share_begin(r + 1) - share_begin(r);
    rank_counts_.push_back(static_cast<int>(values * share));
    rank_offsets_.push_back(static_cast<int>(values * share_begin(r)));
    owner_counts_.push_back(static_cast<int>(values * own_share()));
    owner_offsets_.push_back(static_cast<int>(values * own_share() * static_cast<std::size_t>(r)));
  }
}

template class ReducedSystem<float>;
template class ReducedSystem<double>;

}  // namespace bedload
