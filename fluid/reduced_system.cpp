#include "fluid/reduced_system.hpp"

#include <algorithm>

#include "fluid/slab_elimination.hpp"

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
  rows_.resize(own * slabs);
  inverse_last_.resize(own);
  values_.resize(slabs);
  to_owner_.resize(3 * parts_ * modes_);
  at_owner_.resize(3 * parts_ * own * slabs);
  count_messages();
}

template <class Real>
void ReducedSystem<Real>::factorise(std::span<const SlabCoupling> own,
                                    std::optional<std::size_t> open) {
  const std::size_t slabs = static_cast<std::size_t>(ranks_), share = own_share();
  constexpr std::size_t numbers = sizeof(SlabCoupling) / sizeof(double);
  const auto in_numbers = [&](const std::vector<int>& values) {  // from 3 parts to these
    std::vector<int> counts;
    for (const int n : values)
      counts.push_back(n / static_cast<int>(3 * parts_) * static_cast<int>(numbers));
    return counts;
  };
  std::vector<SlabCoupling> all(share * slabs);
  MPI_Alltoallv(own.data(), in_numbers(rank_counts_).data(), in_numbers(rank_offsets_).data(),
                MPI_DOUBLE, all.data(), in_numbers(owner_counts_).data(),
                in_numbers(owner_offsets_).data(), MPI_DOUBLE, comm_);
  for (std::size_t m = 0; m < share; ++m) {
    for (std::size_t r = 0; r < slabs; ++r) {
      const SlabCoupling& slab = all[r * share + m];
      rows_[m * slabs + r] = {.c = slab.c,
                              .f = slab.f,
                              .alpha = slab.alpha,
                              .beta = slab.beta,
                              .lower = 0.0,
                              .inverse_pivot = 0.0,
                              .upper = 0.0,
                              .response = 0.0};
    }
    factorise_mode(m);
    if (open && share_begin(rank_) + m == *open) inverse_last_[m] = 0.0;
  }
}

/// Eliminates Y: row r reads lower X_r-1 + diagonal X_r + upper X_r+1 = right-hand side with
///   lower = f_r,  diagonal = 1 + c_r alpha_r+1,  upper = c_r beta_r+1,
/// then writes X_r = y_r - response_r X_last, which closes a cyclic system as well as an open one.
template <class Real>
void ReducedSystem<Real>::factorise_mode(std::size_t mode) {
  const std::size_t slabs = static_cast<std::size_t>(ranks_), last = slabs - 1;
  Row* row = &rows_[mode * slabs];
  const auto diagonal = [&](std::size_t r) { return 1.0 + row[r].c * row[(r + 1) % slabs].alpha; };
  const auto upper = [&](std::size_t r) { return row[r].c * row[(r + 1) % slabs].beta; };
  if (slabs == 1) {
    row[0].lower = row[0].f;
    inverse_last_[mode] = 1.0 / (row[0].f + diagonal(0) + upper(0));
    return;
  }
  for (std::size_t r = 0; r < slabs; ++r) {
    row[r].lower = row[r].f;
    const double before = r > 0 ? row[r - 1].upper : 0.0;
    const double response_before = r > 0 ? row[r - 1].response : -1.0;
    if (r == last) break;
    row[r].inverse_pivot = 1.0 / (diagonal(r) - row[r].lower * before);
    row[r].upper = upper(r) * row[r].inverse_pivot;
    row[r].response = -row[r].lower * response_before * row[r].inverse_pivot;
  }
  row[last - 1].response += row[last - 1].upper;
  for (std::size_t r = last - 1; r-- > 0;) row[r].response -= row[r].upper * row[r + 1].response;
  inverse_last_[mode] = 1.0 / (diagonal(last) - row[last].lower * row[last - 1].response -
                               upper(last) * row[0].response);
}

template <class Real>
void ReducedSystem<Real>::solve_mode(std::size_t mode) {
  const std::size_t slabs = static_cast<std::size_t>(ranks_), last = slabs - 1;
  const Row* row = &rows_[mode * slabs];
  Values* value = values_.data();
  const auto right_hand_side = [&](std::size_t r) {
    const std::size_t next = (r + 1) % slabs, before = (r + last) % slabs;
    return value[r].last - row[r].f * value[before].excess -
           row[r].c * (value[next].first + row[next].alpha * value[r].excess);
  };
  if (slabs == 1) {
    value[0].x = right_hand_side(0) * inverse_last_[mode];
    return;
  }
  for (std::size_t r = 0; r < last; ++r) {
    double d = right_hand_side(r);
    if (r > 0) d -= row[r].lower * value[r - 1].x;
    value[r].x = d * row[r].inverse_pivot;
  }
  for (std::size_t r = last - 1; r-- > 0;) value[r].x -= row[r].upper * value[r + 1].x;
  const double upper = row[last].c * row[0].beta;
  value[last].x = inverse_last_[mode] * (right_hand_side(last) -
                                         row[last].lower * value[last - 1].x - upper * value[0].x);
  for (std::size_t r = 0; r < last; ++r) value[r].x -= row[r].response * value[last].x;
}

template <class Real>
void ReducedSystem<Real>::solve(const Known& known, const Wanted& wanted) {
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
  for (std::size_t n = 0; n < own; ++n) {
    const std::size_t mode = n / parts_;
    for (std::size_t r = 0; r < slabs; ++r) {
      const Real* in = at_owner_.data() + 3 * own * r + n;
      values_[r].last = static_cast<double>(in[0]);
      values_[r].first = static_cast<double>(in[own]);
      values_[r].excess = static_cast<double>(in[2 * own]);
    }
    solve_mode(mode);
    const Row* row = &rows_[mode * slabs];
    for (std::size_t r = 0; r < slabs; ++r) {
      const std::size_t next = (r + 1) % slabs, before = (r + slabs - 1) % slabs;
      Real* out = at_owner_.data() + 3 * own * r + n;
      const double seen_by_next = values_[r].x + values_[r].excess;
      out[0] = static_cast<Real>(values_[before].x + values_[before].excess);
      out[own] = static_cast<Real>(values_[r].x);
      out[2 * own] = static_cast<Real>(values_[next].first + row[next].alpha * seen_by_next +
                                       row[next].beta * values_[next].x);
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

template <class Real>
std::size_t ReducedSystem<Real>::values_sent() const {
  const std::size_t values = 3 * parts_;
  return values * (modes_ - own_share()) +
         values * own_share() * static_cast<std::size_t>(ranks_ - 1);
}

template class ReducedSystem<float>;
template class ReducedSystem<double>;

}  // namespace bedload
