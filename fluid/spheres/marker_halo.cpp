#include "fluid/spheres/marker_halo.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace bedload {
namespace {

/// How far from a plane, in cells, a marker may be to touch it, whatever its component's
/// staggering: 1 1/2 on its own grid, at most 1 more because rows and interfaces are counted by
/// cells.
constexpr double reach = 3.0;

/// Half the width of a sphere's cut at `distance` from its centre plane, negative if it is missed.
double half_chord(double radius, double distance) {
  const double square = radius * radius - distance * distance;
  return square < 0.0 ? -1.0 : std::sqrt(square);
}

/// Sphere centres as seen from a place: the sphere itself and, where periodic, its images.
std::array<double, 3> images(double centre, double length, bool periodic) {
  return {centre, periodic ? centre - length : centre, periodic ? centre + length : centre};
}

constexpr int upwards = 11, downwards = 12;  // message tags

}  // namespace

MarkerHalo::MarkerHalo(const Grid& grid, const Decomposition& slabs) : grid_(grid), slabs_(slabs) {
  forget();
}

void MarkerHalo::forget() {
  const auto nz = static_cast<std::size_t>(grid_.cells[2]);
  const auto planes = static_cast<std::size_t>(slabs_.planes());
  marked_.below.assign(nz, 0);
  marked_.above.assign(nz, 0);
  marked_.seam.assign((planes + 2) * nz, 0);
  kept_ = marked_;
}

void MarkerHalo::mark_rows(std::vector<char>& rows, std::size_t first, double z,
                           double half_width) const {
  const int nz = grid_.cells[2];
  const double h = grid_.h;
  const int lowest = static_cast<int>(std::floor((z - half_width) / h - reach));
  const int highest = static_cast<int>(std::floor((z + half_width) / h + reach));
  for (int k = lowest; k <= std::min(highest, lowest + nz - 1); ++k) {
    if (grid_.periodic(2))
      rows[first + static_cast<std::size_t>(((k % nz) + nz) % nz)] = 1;
    else if (k >= 0 && k < nz)
      rows[first + static_cast<std::size_t>(k)] = 1;
  }
}

void MarkerHalo::mark(const Vec3& centre, double radius) {
  const double h = grid_.h;
  const auto cut = [&](double size, double distance) {  // nearest cut within reach
    return half_chord(size, std::max(std::abs(distance) - reach * h, 0.0));
  };
  const std::array<double, 3> ys = images(centre.y(), grid_.length[1], grid_.periodic(1));
  // The same arithmetic on both sides of an interface, the one that closes periodic y included: the
  // neighbours must mark the same rows.
  const int behind = slabs_.first() + slabs_.planes();
  const int upper_face = grid_.periodic(1) ? behind % grid_.cells[1] : behind;
  for (const double y : ys) {
    const double lower = cut(radius, y - slabs_.first() * h);
    if (lower >= 0.0) mark_rows(marked_.below, 0, centre.z(), lower);
    const double upper = cut(radius, y - upper_face * h);
    if (upper >= 0.0) mark_rows(marked_.above, 0, centre.z(), upper);
  }

  if (!grid_.periodic(0)) return;
  const double seam = std::min(centre.x(), grid_.length[0] - centre.x());
  const double disc = cut(radius, seam);
  if (disc < 0.0) return;
  const auto nz = static_cast<std::size_t>(grid_.cells[2]);
  for (const double y : ys)
    for (int j = -1; j <= slabs_.planes(); ++j) {
      const double chord = cut(disc, y - grid_.centre(slabs_.first() + j));
      if (chord >= 0.0)
        mark_rows(marked_.seam, static_cast<std::size_t>(j + 1) * nz, centre.z(), chord);
    }
}

void MarkerHalo::finish() {
  const int nz = grid_.cells[2];
  below_.clear();
  above_.clear();
  seam_.clear();
  for (int k = 0; k < nz; ++k) {
    if (!slabs_.at_lower_wall() && marked_.below[static_cast<std::size_t>(k)]) below_.push_back(k);
    if (!slabs_.at_upper_wall() && marked_.above[static_cast<std::size_t>(k)]) above_.push_back(k);
  }
  const int lowest = slabs_.at_lower_wall() ? 0 : -1;
  const int highest = slabs_.at_upper_wall() ? slabs_.planes() - 1 : slabs_.planes();
  for (int j = lowest; j <= highest; ++j)
    for (int k = 0; k < nz; ++k)
      if (marked_.seam[static_cast<std::size_t>(j + 1) * static_cast<std::size_t>(nz) +
                       static_cast<std::size_t>(k)])
        seam_.emplace_back(j, k);
}

namespace {

/// One z row with all its components and their x ghosts, contiguous in memory.
template <class Real>
std::size_t row_block(const Field<Real>& field) {
  return field.component_stride() * static_cast<std::size_t>(field.components());
}

template <class Real>
std::vector<Real> packed(const Field<Real>& field, int j, const std::vector<int>& rows) {
  const std::size_t block = row_block(field);
  std::vector<Real> message(rows.size() * block);
  for (std::size_t n = 0; n < rows.size(); ++n)
    std::copy_n(field.row(j, rows[n]) - 1, block, message.data() + n * block);
  return message;
}

/// Sends the rows `down` to the slab below and `up` to the one above; returns what they send, first
/// from below, then from above.
template <class Real>
std::array<std::vector<Real>, 2> swap_rows(const Decomposition& slabs,
                                           const std::vector<Real>& down,
                                           const std::vector<Real>& up) {
  std::array<std::vector<Real>, 2> received{std::vector<Real>(down.size()),
                                            std::vector<Real>(up.size())};
  const MPI_Datatype type = mpi_type<Real>();
  const auto length = [](const std::vector<Real>& v) { return static_cast<int>(v.size()); };
  std::array<MPI_Request, 4> requests;
  requests.fill(MPI_REQUEST_NULL);
  if (!down.empty()) {
    MPI_Irecv(received[0].data(), length(down), type, slabs.below(), upwards, slabs.comm(),
              &requests[0]);
    MPI_Isend(down.data(), length(down), type, slabs.below(), downwards, slabs.comm(),
              &requests[1]);
  }
  if (!up.empty()) {
    MPI_Irecv(received[1].data(), length(up), type, slabs.above(), downwards, slabs.comm(),
              &requests[2]);
    MPI_Isend(up.data(), length(up), type, slabs.above(), upwards, slabs.comm(), &requests[3]);
  }
  MPI_Waitall(4, requests.data(), MPI_STATUSES_IGNORE);
  return received;
}

}  // namespace

template <class Real>
void MarkerHalo::clear_ghosts(Field<Real>& field) const {
  const std::size_t block = row_block(field);
  for (const int k : below_) std::fill_n(field.row(-1, k) - 1, block, Real{});
  for (const int k : above_) std::fill_n(field.row(field.planes(), k) - 1, block, Real{});
  for (const auto& [j, k] : seam_)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(j, k, c);
      row[-1] = row[field.nx()] = Real{};
    }
}

template <class Real>
void MarkerHalo::clear_touched(Field<Real>& field) const {
  const std::size_t block = row_block(field);
  const int nx = field.nx(), top = field.planes() - 1;
  for (const int j : {-1, 0})
    for (const int k : below_) std::fill_n(field.row(j, k) - 1, block, Real{});
  for (const int j : {top, top + 1})
    for (const int k : above_) std::fill_n(field.row(j, k) - 1, block, Real{});
  for (const auto& [j, k] : seam_)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(j, k, c);
      row[-1] = row[0] = row[nx - 1] = row[nx] = Real{};
    }
}

template <class Real>
void MarkerHalo::collect(Field<Real>& field) const {
  const int nx = field.nx(), top = field.planes() - 1;
  for (const auto& [j, k] : seam_)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(j, k, c);
      row[nx - 1] += row[-1];
      row[0] += row[nx];
      row[-1] = row[nx] = Real{};
    }
  const auto received =
      swap_rows(slabs_, packed(field, -1, below_), packed(field, top + 1, above_));
  const auto add = [&field, nx](int j, const std::vector<int>& rows,
                                const std::vector<Real>& message) {
    const std::size_t block = row_block(field), stride = field.component_stride();
    for (std::size_t n = 0; n < rows.size(); ++n)
      for (int c = 0; c < field.components(); ++c) {
        Real* row = field.row(j, rows[n], c);
        const Real* gain = message.data() + n * block + static_cast<std::size_t>(c) * stride + 1;
        for (int i = 0; i < nx; ++i) row[i] += gain[i];
      }
  };
  add(0, below_, received[0]);
  add(top, above_, received[1]);
}

template <class Real>
void MarkerHalo::refresh(Field<Real>& field) const {
  const int nx = field.nx(), top = field.planes() - 1;
  for (const auto& [j, k] : seam_)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(j, k, c);
      row[-1] = row[nx - 1];
      row[nx] = row[0];
    }
  const auto received = swap_rows(slabs_, packed(field, 0, below_), packed(field, top, above_));
  const std::size_t block = row_block(field);
  for (std::size_t n = 0; n < below_.size(); ++n)
    std::copy_n(received[0].data() + n * block, block, field.row(-1, below_[n]) - 1);
  for (std::size_t n = 0; n < above_.size(); ++n)
    std::copy_n(received[1].data() + n * block, block, field.row(top + 1, above_[n]) - 1);
}

template void MarkerHalo::clear_ghosts(Field<float>&) const;
template void MarkerHalo::clear_ghosts(Field<double>&) const;
template void MarkerHalo::clear_touched(Field<float>&) const;
template void MarkerHalo::collect(Field<float>&) const;
template void MarkerHalo::clear_touched(Field<double>&) const;
template void MarkerHalo::collect(Field<double>&) const;
template void MarkerHalo::refresh(Field<float>&) const;
template void MarkerHalo::refresh(Field<double>&) const;

}  // namespace bedload
