#include "fluid/poisson/distributed_transform.hpp"

#include <algorithm>
#include <cstddef>

#include "fluid/kernels/independent_loop.hpp"

namespace bedload {
namespace {

/// a + i b, and back.
template <class Real>
void weave(int count, const Real* a, const Real* b, Real* both) {
  BEDLOAD_INDEPENDENT_LOOP
  for (int i = 0; i < count; ++i) {
    both[2 * i] = a[i];
    both[2 * i + 1] = b[i];
  }
}
template <class Real>
void unweave(int count, const Real* both, Real* a, Real* b) {
  BEDLOAD_INDEPENDENT_LOOP
  for (int i = 0; i < count; ++i) {
    a[i] = both[2 * i];
    b[i] = both[2 * i + 1];
  }
}

/// From the modes C of a + i b twice those of a and b, number `first` and `count` - 1 that follow:
/// A_m = C_m + conj C_n-m, B_m = -i (C_m - conj C_n-m); C_n stands behind the last mode.
template <class Real>
void take_apart(int n, int first, int count, const Real* both, Real* a, Real* b) {
  const Real *c = both + 2 * first, *d = both + 2 * (n - first);
  BEDLOAD_INDEPENDENT_LOOP
  for (int m = 0; m < count; ++m) {
    a[2 * m] = c[2 * m] + d[-2 * m];
    a[2 * m + 1] = c[2 * m + 1] - d[-2 * m + 1];
    b[2 * m] = c[2 * m + 1] + d[-2 * m + 1];
    b[2 * m + 1] = d[-2 * m] - c[2 * m];
  }
}

/// The reverse: C_m = A + i B, C_n-m = conj A + i conj B.
template <class Real>
void put_together(int n, int first, int count, const Real* a, const Real* b, Real* both) {
  Real *c = both + 2 * first, *d = both + 2 * (n - first);
  BEDLOAD_INDEPENDENT_LOOP
  for (int m = 0; m < count; ++m) {
    d[-2 * m] = a[2 * m] + b[2 * m + 1];
    d[-2 * m + 1] = b[2 * m] - a[2 * m + 1];
    c[2 * m] = a[2 * m] - b[2 * m + 1];
    c[2 * m + 1] = a[2 * m + 1] + b[2 * m];
  }
}

}  // namespace

template <class Real>
DistributedTransform<Real>::DistributedTransform(const Grid& grid, int component,
                                                 const Decomposition& decomposition)
    : Base(grid, component, decomposition),
      comm_(decomposition.z_comm()),
      rank_(decomposition.z_part()),
      ranks_(decomposition.z_parts()),
      all_rows_(grid.cells[2]),
      all_columns_(this->periodic_x() ? nx_ / 2 + 1 : nx_),
      column_width_(this->periodic_x() ? 2 : 1),
      places_(parts_of_z()) {
  const bool half = this->periodic_z() && !this->periodic_x();
  this->shape_modes(1, (half ? all_rows_ / 2 + 1 : all_rows_) * own_columns());
  // Sine and cosine transforms there and back multiply by twice the cells; along periodic x, too,
  // because taking rows apart doubles.
  this->normalisation_ =
      1.0 / (2.0 * double(nx_) * double(all_rows_) * (this->periodic_z() ? 1.0 : 2.0));
  const int own = static_cast<int>(column_row()), rows = this->nz() + 1;
  int row_offset = 0, column_offset = 0;
  for (int r = 0; r < ranks_; ++r) {
    first_row_.push_back(decomposition.first_row(r));
    own_rows_.counts.push_back(rows * column_width_ * (first_column(r + 1) - first_column(r)));
    own_rows_.offsets.push_back(row_offset);
    row_offset += own_rows_.counts.back();
    own_columns_.counts.push_back((decomposition.rows(r) + 1) * own);
    own_columns_.offsets.push_back(column_offset);
    column_offset += own_columns_.counts.back();
    all_blocks_.offsets.push_back(decomposition.first_row(r) * own);
  }
  all_blocks_.counts = own_columns_.counts;
  first_row_.push_back(all_rows_);
  for (AlignedArray<Real>* line : {&line_, &modes_})
    *line = AlignedArray<Real>(2 * static_cast<std::size_t>(nx_) + 2);
  columns_ = AlignedArray<Real>(static_cast<std::size_t>(all_rows_) * columns_pitch());
  for (Passage& passage : passages_) {
    passage.rows = AlignedArray<Real>(static_cast<std::size_t>(row_offset));
    passage.columns = AlignedArray<Real>(static_cast<std::size_t>(column_offset));
  }
  plan(decomposition.comm());
  std::fill_n(columns_.data(), columns_.size(), Real(0));  // planning wrote to it, to the pad, too
}

template <class Real>
std::size_t DistributedTransform<Real>::column_row() const {
  return static_cast<std::size_t>(own_columns()) * static_cast<std::size_t>(column_width_);
}

template <class Real>
void DistributedTransform<Real>::plan(MPI_Comm comm) {
  using Plan = FourierPlan<Real>;
  AlignedArray<Real> row(this->real_pitch()), modes(this->pitch() * 2);
  Real *p = row.data(), *l = line_.data(), *x = modes_.data();
  Real *c = columns_.data(), *m = modes.data();
  const int own = own_columns(), reals = static_cast<int>(column_row());
  plan_alike<Real>(comm, own, [&] {
    if (this->periodic_x()) {
      forward_x_ = Plan::complex({{nx_}, 1}, l, x, FFTW_FORWARD);
      inverse_x_ = Plan::complex({{nx_}, 1}, x, l, FFTW_BACKWARD);
    } else {
      forward_x_ = Plan::real(basis_x_, true, {{nx_}, 1}, p, l);
      inverse_x_ = Plan::real(basis_x_, false, {{nx_}, 1}, l, p);
    }
    if (own == 0) return;
    if (!this->periodic_z()) {
      forward_z_ = Plan::real(basis_z_, true, {{all_rows_}, reals, reals, 1}, c, m);
      inverse_z_ = Plan::real(basis_z_, false, {{all_rows_}, reals, reals, 1}, m, c);
    } else if (this->periodic_x()) {
      const int pitch = static_cast<int>(columns_pitch()) / column_width_;
      const FftwShape shape{places_.parts, pitch, pitch, 1};
      forward_z_ = Plan::complex(shape, c, in_parts() ? c : m, FFTW_FORWARD);
      inverse_z_ = Plan::complex(shape, in_parts() ? c : m, c, FFTW_BACKWARD);
    } else {
      forward_z_ = Plan::to_complex({{all_rows_}, own, own, 1}, c, m);
      inverse_z_ = Plan::to_real({{all_rows_}, own, own, 1}, m, c);
    }
  });
}

template <class Real>
double DistributedTransform<Real>::eigenvalue(int mode, int) const {
  return second_difference(basis_x_, first_column(rank_) + mode % own_columns(), nx_) +
         second_difference(basis_z_, mode / own_columns(), all_rows_);
}

/// Sends and receives one message per rank of the plane; the own one is copied.
template <class Real>
void DistributedTransform<Real>::start(Passage& passage, const Real* from, const Layout& leaving,
                                       Real* to, const Layout& coming) {
  constexpr int tag = 0;
  const MPI_Datatype type = mpi_type<Real>();
  for (int r = 0; r < ranks_; ++r) {
    const auto n = static_cast<std::size_t>(r);
    if (r == rank_ || coming.counts[n] == 0) continue;
    MPI_Irecv(to + coming.offsets[n], coming.counts[n], type, r, tag, comm_,
              &passage.coming.emplace_back());
  }
  for (int r = 0; r < ranks_; ++r) {
    const auto n = static_cast<std::size_t>(r);
    if (r == rank_ || leaving.counts[n] == 0) continue;
    MPI_Isend(from + leaving.offsets[n], leaving.counts[n], type, r, tag, comm_,
              &passage.leaving.emplace_back());
  }
  const auto me = static_cast<std::size_t>(rank_);
  std::copy_n(from + leaving.offsets[me], leaving.counts[me], to + coming.offsets[me]);
}

template <class Real>
void DistributedTransform<Real>::finish(std::vector<MPI_Request>& requests) {
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  requests.clear();
}

template <class Real>
typename DistributedTransform<Real>::Passage& DistributedTransform<Real>::next() {
  Passage& passage = passages_[static_cast<std::size_t>(begun_ % 2)];
  finish(passage.leaving);
  return passage;
}

/// Calls use(first mode, modes, their place) for what each rank gets or gives of row k.
template <class Real>
template <class Use>
void DistributedTransform<Real>::for_pieces(Passage& passage, int k, Use use) {
  for (int r = 0; r < ranks_; ++r) {
    const int first = first_column(r), count = first_column(r + 1) - first;
    use(first, count,
        passage.rows.data() + own_rows_.offsets[static_cast<std::size_t>(r)] +
            static_cast<std::ptrdiff_t>(k) * count * column_width_);
  }
}

template <class Real>
void DistributedTransform<Real>::begin_forward(Real* plane) {
  Passage& passage = next();
  const int rows = this->nz() + 1;
  if (this->periodic_x()) {
    for (int k = 0; k < rows; k += 2) {
      const int to_partner = k + 1 < rows ? 1 : 0;  // the last of an odd number is its own
      const Real* row = real_row(plane, k);
      weave(nx_, row, real_row(plane, k + to_partner), line_.data());
      forward_x_(line_.data(), modes_.data());
      std::copy_n(modes_.data(), 2, &modes_[2 * static_cast<std::size_t>(nx_)]);
      for_pieces(passage, k, [&](int first, int count, Real* place) {
        take_apart(nx_, first, count, modes_.data(), place, place + to_partner * 2 * count);
      });
    }
  } else {
    if (basis_x_ == Basis::faces) line_[static_cast<std::size_t>(nx_) - 1] = Real(0);
    for (int k = 0; k < rows; ++k) {
      forward_x_(real_row(plane, k), line_.data());
      for_pieces(passage, k, [&](int first, int count, Real* place) {
        std::copy_n(line_.data() + first, count, place);
      });
    }
  }
  start(passage, passage.rows.data(), own_rows_, passage.columns.data(), own_columns_);
  ++begun_;
}

template <class Real>
void DistributedTransform<Real>::end_forward() {
  Passage& passage = oldest();
  finish(passage.coming);
  ++ended_;
  // Rows of rank r stand behind each other; its additional row belongs to the first of rank r+1.
  const std::size_t own = column_row();
  for (int r = 0; r < ranks_; ++r) {
    const auto n = static_cast<std::size_t>(r);
    const Real* from = passage.columns.data() + own_columns_.offsets[n];
    for (int k = first_row_[n]; k < first_row_[n + 1]; ++k, from += own)
      std::copy_n(from, own, point_row(k));
  }
  for (int r = 0; r < ranks_; ++r) {
    if (r + 1 == ranks_ && !this->periodic_z()) continue;
    const auto n = static_cast<std::size_t>(r);
    const Real* excess =
        passage.columns.data() + own_columns_.offsets[n] + own_columns_.counts[n] - own;
    Real* to = point_row(first_row_[n + 1] % all_rows_);
    for (std::size_t i = 0; i < own; ++i) to[i] += excess[i];
  }
}

template <class Real>
void DistributedTransform<Real>::forward_row(Real*, int, Real* out) {
  if (own_columns() == 0) return;
  const std::size_t own = column_row();
  if (in_parts()) {
    forward_z_(columns_.data(), columns_.data());
    for (int k = 0; k < all_rows_; ++k, out += own) std::copy_n(mode_row(k), own, out);
    return;
  }
  forward_z_(columns_.data(), out);
  if (basis_z_ == Basis::faces)  // the last face is the wall
    std::fill_n(out + static_cast<std::size_t>(all_rows_ - 1) * own, own, Real(0));
}

template <class Real>
void DistributedTransform<Real>::inverse_row(Real* in, int, Real*) {
  if (own_columns() == 0) return;
  Real* columns = next().columns.data();
  const std::size_t own = column_row(), all = static_cast<std::size_t>(all_rows_) * own;
  if (in_parts()) {
    for (int k = 0; k < all_rows_; ++k, in += own) std::copy_n(in, own, mode_row(k));
    inverse_z_(columns_.data(), columns_.data());
    Real* to = columns;
    for (int k = 0; k < all_rows_; ++k, to += own) std::copy_n(point_row(k), own, to);
  } else {
    if (basis_z_ == Basis::faces) std::fill_n(columns + all - own, own, Real(0));
    inverse_z_(in, columns);
  }
  std::copy_n(columns + (this->periodic_z() ? 0 : all - own), own, columns + all);
}

template <class Real>
void DistributedTransform<Real>::begin_inverse() {
  Passage& passage = next();
  // Each rank's rows and the next one.
  start(passage, passage.columns.data(), all_blocks_, passage.rows.data(), own_rows_);
  ++begun_;
}

template <class Real>
void DistributedTransform<Real>::end_inverse(Real* plane) {
  Passage& passage = oldest();
  finish(passage.coming);
  ++ended_;
  const int rows = this->nz() + 1;
  if (this->periodic_x()) {
    for (int k = 0; k < rows; k += 2) {
      const int to_partner = k + 1 < rows ? 1 : 0;
      for_pieces(passage, k, [&](int first, int count, const Real* place) {
        put_together(nx_, first, count, place, place + to_partner * 2 * count, modes_.data());
      });
      inverse_x_(modes_.data(), line_.data());
      unweave(nx_, line_.data(), real_row(plane, k), real_row(plane, k + to_partner));
    }
    return;
  }
  for (int k = 0; k < rows; ++k) {
    for_pieces(passage, k, [&](int first, int count, const Real* place) {
      std::copy_n(place, count, line_.data() + first);
    });
    Real* row = real_row(plane, k);
    if (basis_x_ == Basis::faces) row[nx_ - 1] = Real(0);
    inverse_x_(line_.data(), row);
  }
}

template class DistributedTransform<float>;
template class DistributedTransform<double>;

}  // namespace bedload
