#include "fluid/immersed_boundary/marker_halo.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fluid/immersed_boundary/dispersion_correction.hpp"

namespace bedload {
namespace {

/// How far from a plane, in cells, a sphere's surface may be for its sphere to touch it, whatever
/// the component's staggering: markers spread 1 1/2 on their own grid, the correction of what the
/// sphere carries along 1 more than its own reach, and at most 1 comes in addition because rows and
/// interfaces are counted by cells.
constexpr double reach = dispersion_reach + 2.0;

/// Half the width of a sphere's cut at `distance` from its centre plane, negative if it is missed.
double half_chord(double radius, double distance) {
  const double square = radius * radius - distance * distance;
  return square < 0.0 ? -1.0 : std::sqrt(square);
}

/// Sphere centres as seen from a place: the sphere itself and, where periodic, its images.
std::array<double, 3> images(double centre, double length, bool periodic) {
  return {centre, periodic ? centre - length : centre, periodic ? centre + length : centre};
}

/// Message tags: with two parts along a periodic direction the neighbours are one rank.
constexpr int towards_lower = 11, towards_higher = 12;

}  // namespace

MarkerHalo::MarkerHalo(const Grid& grid, const Decomposition& decomposition)
    : grid_(grid), decomposition_(decomposition) {
  forget();
}

void MarkerHalo::forget() {
  const auto rows = static_cast<std::size_t>(decomposition_.rows()) + 2;
  const auto planes = static_cast<std::size_t>(decomposition_.planes()) + 2;
  for (std::vector<char>* across_y : {&marked_.below, &marked_.above}) across_y->assign(rows, 0);
  for (std::vector<char>* across_z : {&marked_.back, &marked_.front}) across_z->assign(planes, 0);
  marked_.seam.assign(planes * rows, 0);
  kept_ = marked_;
}

/// Marks those of this block's rows, ghost rows included, that lie within reach of z +- half_width.
void MarkerHalo::mark_rows(std::vector<char>& rows, std::size_t first, double z,
                           double half_width) const {
  const double middle = z / grid_.h - decomposition_.first_row(),
               width = half_width / grid_.h + reach;
  const int lowest = std::max(-1, static_cast<int>(std::floor(middle - width)));
  const int highest = std::min(decomposition_.rows(), static_cast<int>(std::floor(middle + width)));
  for (int k = lowest; k <= highest; ++k) rows[first + static_cast<std::size_t>(k + 1)] = 1;
}

void MarkerHalo::mark_planes(std::vector<char>& planes, double y, double half_width) const {
  const double middle = y / grid_.h - decomposition_.first(), width = half_width / grid_.h + reach;
  const int lowest = std::max(-1, static_cast<int>(std::floor(middle - width)));
  const int highest =
      std::min(decomposition_.planes(), static_cast<int>(std::floor(middle + width)));
  for (int j = lowest; j <= highest; ++j) planes[static_cast<std::size_t>(j + 1)] = 1;
}

void MarkerHalo::mark(const Vec3& centre, double radius) {
  const double h = grid_.h;
  const auto cut = [&](double size, double distance) {  // nearest cut within reach
    return half_chord(size, std::max(std::abs(distance) - reach * h, 0.0));
  };
  const std::array<double, 3> ys = images(centre.y(), grid_.length[1], grid_.periodic(1));
  const std::array<double, 3> zs = images(centre.z(), grid_.length[2], grid_.periodic(2));
  // The same arithmetic on both sides of an interface, the one that closes a periodic direction
  // included: the neighbours must mark the same rows.
  const auto upper_end = [&](int direction, int end) {
    const int cells = grid_.cells[static_cast<std::size_t>(direction)];
    return grid_.periodic(direction) ? end % cells : end;
  };
  const int top = upper_end(1, decomposition_.first() + decomposition_.planes());
  const int front = upper_end(2, decomposition_.first_row() + decomposition_.rows());
  for (const double y : ys)
    for (const double z : zs) {
      const double below = cut(radius, y - decomposition_.first() * h);
      if (below >= 0.0) mark_rows(marked_.below, 0, z, below);
      const double above = cut(radius, y - top * h);
      if (above >= 0.0) mark_rows(marked_.above, 0, z, above);
      const double behind = cut(radius, z - decomposition_.first_row() * h);
      if (behind >= 0.0) mark_planes(marked_.back, y, behind);
      const double ahead = cut(radius, z - front * h);
      if (ahead >= 0.0) mark_planes(marked_.front, y, ahead);
    }

  if (!grid_.periodic(0)) return;
  const double seam = std::min(centre.x(), grid_.length[0] - centre.x());
  const double disc = cut(radius, seam);
  if (disc < 0.0) return;
  const auto rows = static_cast<std::size_t>(decomposition_.rows()) + 2;
  for (const double y : ys)
    for (int j = -1; j <= decomposition_.planes(); ++j) {
      const double chord = cut(disc, y - grid_.centre(decomposition_.first() + j));
      if (chord < 0.0) continue;
      for (const double z : zs)
        mark_rows(marked_.seam, static_cast<std::size_t>(j + 1) * rows, z, chord);
    }
}

void MarkerHalo::finish() {
  const int nz = decomposition_.rows(), planes = decomposition_.planes();
  const auto marked = [](const std::vector<char>& flags, int n) {
    return flags[static_cast<std::size_t>(n + 1)] != 0;
  };
  for (std::vector<int>* list : {&below_, &above_, &back_, &front_}) list->clear();
  seam_.clear();
  for (int k = 0; k < nz; ++k) {
    if (!decomposition_.at_lower_wall() && marked(marked_.below, k)) below_.push_back(k);
    if (!decomposition_.at_upper_wall() && marked(marked_.above, k)) above_.push_back(k);
  }
  const int lowest = decomposition_.at_lower_wall() ? 0 : -1;
  const int highest = decomposition_.at_upper_wall() ? planes - 1 : planes;
  // Undivided periodic z has no ghost rows of its own.
  const bool has_back = decomposition_.divides_rows() && !decomposition_.at_back_wall();
  const bool has_front = decomposition_.divides_rows() && !decomposition_.at_front_wall();
  for (int j = lowest; j <= highest; ++j) {
    if (has_back && marked(marked_.back, j)) back_.push_back(j);
    if (has_front && marked(marked_.front, j)) front_.push_back(j);
    for (int k = has_back ? -1 : 0; k < nz + (has_front ? 1 : 0); ++k)
      if (marked_.seam[static_cast<std::size_t>(j + 1) * static_cast<std::size_t>(nz + 2) +
                       static_cast<std::size_t>(k + 1)])
        seam_.emplace_back(j, k);
  }
}

namespace {

/// Rows (j, k) of a field that are sent, received or emptied together.
using Place = std::pair<int, int>;

std::vector<Place> on_plane(int j, const std::vector<int>& rows) {
  std::vector<Place> places;
  places.reserve(rows.size());
  for (const int k : rows) places.emplace_back(j, k);
  return places;
}

std::vector<Place> in_row(int k, const std::vector<int>& planes) {
  std::vector<Place> places;
  places.reserve(planes.size());
  for (const int j : planes) places.emplace_back(j, k);
  return places;
}

template <class Real>
void empty(Field<Real>& field, const std::vector<Place>& places) {
  for (const auto& [j, k] : places) std::fill_n(field.row_block(j, k), field.row_size(), Real{});
}

template <class Real>
std::vector<Real> packed(const Field<Real>& field, const std::vector<Place>& places) {
  const std::size_t block = field.row_size();
  std::vector<Real> message(places.size() * block);
  for (std::size_t n = 0; n < places.size(); ++n)
    std::copy_n(field.row_block(places[n].first, places[n].second), block,
                message.data() + n * block);
  return message;
}

template <class Real>
void store(Field<Real>& field, const std::vector<Place>& places, const std::vector<Real>& message) {
  const std::size_t block = field.row_size();
  for (std::size_t n = 0; n < places.size(); ++n)
    std::copy_n(message.data() + n * block, block,
                field.row_block(places[n].first, places[n].second));
}

template <class Real>
void add(Field<Real>& field, const std::vector<Place>& places, const std::vector<Real>& message) {
  const std::size_t block = field.row_size(), stride = field.component_stride();
  for (std::size_t n = 0; n < places.size(); ++n)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(places[n].first, places[n].second, c);
      const Real* gain = message.data() + n * block + static_cast<std::size_t>(c) * stride + 1;
      for (int i = 0; i < field.nx(); ++i) row[i] += gain[i];
    }
}

/// Sends two messages to the neighbours `lower` and `higher` of a direction; returns what they
/// send, of the same lengths, in this order.
template <class Real>
std::array<std::vector<Real>, 2> swap(MPI_Comm comm, int lower, int higher,
                                      const std::vector<Real>& to_lower,
                                      const std::vector<Real>& to_higher) {
  std::array<std::vector<Real>, 2> received{std::vector<Real>(to_lower.size()),
                                            std::vector<Real>(to_higher.size())};
  const MPI_Datatype type = mpi_type<Real>();
  const auto length = [](const std::vector<Real>& v) { return static_cast<int>(v.size()); };
  std::array<MPI_Request, 4> requests;
  requests.fill(MPI_REQUEST_NULL);
  if (!to_lower.empty()) {
    MPI_Irecv(received[0].data(), length(to_lower), type, lower, towards_higher, comm,
              &requests[0]);
    MPI_Isend(to_lower.data(), length(to_lower), type, lower, towards_lower, comm, &requests[1]);
  }
  if (!to_higher.empty()) {
    MPI_Irecv(received[1].data(), length(to_higher), type, higher, towards_lower, comm,
              &requests[2]);
    MPI_Isend(to_higher.data(), length(to_higher), type, higher, towards_higher, comm,
              &requests[3]);
  }
  MPI_Waitall(4, requests.data(), MPI_STATUSES_IGNORE);
  return received;
}

/// Adds the ghosts `lower_ghosts` and `higher_ghosts` to the neighbours' rows beside them, and
/// theirs to `lower_rows` and `higher_rows`.
template <class Real>
void bring_home(Field<Real>& field, MPI_Comm comm, int lower, int higher,
                const std::array<std::vector<Place>, 2>& ghosts,
                const std::array<std::vector<Place>, 2>& rows) {
  const auto received =
      swap(comm, lower, higher, packed(field, ghosts[0]), packed(field, ghosts[1]));
  for (const std::size_t end : {0u, 1u}) add(field, rows[end], received[end]);
}

/// The reverse: makes the ghosts equal to the neighbours' rows.
template <class Real>
void fill_from_rows(Field<Real>& field, MPI_Comm comm, int lower, int higher,
                    const std::array<std::vector<Place>, 2>& ghosts,
                    const std::array<std::vector<Place>, 2>& rows) {
  const auto received = swap(comm, lower, higher, packed(field, rows[0]), packed(field, rows[1]));
  for (const std::size_t end : {0u, 1u}) store(field, ghosts[end], received[end]);
}

}  // namespace

template <class Real>
void MarkerHalo::clear_ghosts(Field<Real>& field) const {
  empty(field, on_plane(-1, below_));
  empty(field, on_plane(field.planes(), above_));
  empty(field, in_row(-1, back_));
  empty(field, in_row(field.nz(), front_));
  for (const auto& [j, k] : seam_)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(j, k, c);
      row[-1] = row[field.nx()] = Real{};
    }
}

template <class Real>
void MarkerHalo::clear_touched(Field<Real>& field) const {
  const int nx = field.nx();
  clear_ghosts(field);
  empty(field, on_plane(0, below_));
  empty(field, on_plane(field.planes() - 1, above_));
  empty(field, in_row(0, back_));
  empty(field, in_row(field.nz() - 1, front_));
  for (const auto& [j, k] : seam_)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(j, k, c);
      row[0] = row[nx - 1] = Real{};
    }
}

// Ghost rows go first, those of ghost planes included: the latter then go on to their own block.
template <class Real>
void MarkerHalo::collect(Field<Real>& field) const {
  const int nx = field.nx(), top = field.planes() - 1, last = field.nz() - 1;
  for (const auto& [j, k] : seam_)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(j, k, c);
      row[nx - 1] += row[-1];
      row[0] += row[nx];
      row[-1] = row[nx] = Real{};
    }
  bring_home(field, decomposition_.comm(), decomposition_.back(), decomposition_.front(),
             {in_row(-1, back_), in_row(last + 1, front_)},
             {in_row(0, back_), in_row(last, front_)});
  bring_home(field, decomposition_.comm(), decomposition_.below(), decomposition_.above(),
             {on_plane(-1, below_), on_plane(top + 1, above_)},
             {on_plane(0, below_), on_plane(top, above_)});
}

// The other way round: planes first, then rows with those of the ghost planes.
template <class Real>
void MarkerHalo::refresh(Field<Real>& field) const {
  const int nx = field.nx(), top = field.planes() - 1, last = field.nz() - 1;
  for (const auto& [j, k] : seam_)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(j, k, c);
      row[-1] = row[nx - 1];
      row[nx] = row[0];
    }
  fill_from_rows(field, decomposition_.comm(), decomposition_.below(), decomposition_.above(),
                 {on_plane(-1, below_), on_plane(top + 1, above_)},
                 {on_plane(0, below_), on_plane(top, above_)});
  fill_from_rows(field, decomposition_.comm(), decomposition_.back(), decomposition_.front(),
                 {in_row(-1, back_), in_row(last + 1, front_)},
                 {in_row(0, back_), in_row(last, front_)});
}

template void MarkerHalo::clear_ghosts(Field<float>&) const;
template void MarkerHalo::clear_ghosts(Field<double>&) const;
template void MarkerHalo::clear_touched(Field<float>&) const;
template void MarkerHalo::clear_touched(Field<double>&) const;
template void MarkerHalo::collect(Field<float>&) const;
template void MarkerHalo::collect(Field<double>&) const;
template void MarkerHalo::refresh(Field<float>&) const;
template void MarkerHalo::refresh(Field<double>&) const;

}  // namespace bedload
