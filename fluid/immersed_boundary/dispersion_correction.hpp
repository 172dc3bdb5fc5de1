#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/immersed_boundary/points_along.hpp"
#include "fluid/immersed_boundary/sphere_neighbour.hpp"
#include "fluid/immersed_boundary/stencil.hpp"
#include "fluid/kernels/independent_loop.hpp"
#include "fluid/kernels/prefetch.hpp"
#include "fluid/kernels/simd.hpp"

namespace bedload {

/// How far outside a sphere, in cells, the correction below acts: as far as the forcing leaves
/// gradients from cell to cell.
inline constexpr double dispersion_reach = 2.0;

/// The factor a below: the error k h - sin k h of a wave of six cells, k h = pi/3, over the leading
/// one as the correction has it, sin k h (1 - cos k h)/3.
inline constexpr double dispersion_factor = 1.25;

/// How much of the correction acts in a step of length `dt`. It is a step of Euler's method, whose
/// waves grow with the square of the way V dt in cells, and in fluid at rest around a sphere that
/// has just been kicked it adds to velocities near the limit of the step. So it fades where the
/// surface goes more than half a cell in a step, and is gone at a whole one.
inline double dispersion_share(const SphereState& motion, double h, double dt) {
  const double fastest =
      motion.velocity.lpNorm<1>() + motion.angular_velocity.norm() * motion.radius;
  return std::clamp(2.0 - 2.0 * fastest * dt / h, 0.0, 1.0);
}

/// The layer around a moving sphere goes with it through the grid. Central differences carry what
/// changes from cell to cell too slowly: they give V (q' + h^2/6 q''') for V q'. So the forced
/// layer stays behind its sphere, by V h^2/(6 nu) where that is below h, the drag pulls beside the
/// centre, and a sphere that crosses a stream turns, which one held in the same oblique stream does
/// not (README.md). Where the surface's motion V = U + omega x r carries the fluid, the leading
/// error is therefore taken out of each velocity component q, for each direction d:
///
///   q <- q + a V_d dt/(12 h) (D_+1 - D_-1),   D = q_-1 - 2 q + q_+1,
///
/// for a = 1 the difference to the central difference of fourth order. The layer that the kernel
/// makes is some cells thick, and of waves of six cells that difference is 0.8 of the error, hence
/// the factor dispersion_factor. It is written as what the D of one point gives to its two
/// neighbours along d, so that it makes no momentum; where one of them lies among cells that are no
/// cubes, as beside a wall, central differences stay. The angular momentum that it makes per point
/// and direction across the component, -2 h times a V_d dt/(12 h) D, belongs to the sphere's torque
/// on the fluid.
///
/// Where spheres are close to each other, a point x is corrected once: for the sphere with the
/// smallest |x - x_p|^2 - S^2, S = R + 2 h the radius that the correction reaches to, with that
/// one's motion, and not at all where that one is fixed. Of equal spheres it is the one whose
/// surface is nearest. Planes part the points that spheres share, so that what is left of a row is
/// one piece, and no point within a reach is left out.
template <class Real>
class DispersionCorrection {
 public:
  void clear() {
    rows_.clear();
    begins_.clear();
  }

  /// Notes this rank's points of one component that belong to a sphere, which must come sphere by
  /// sphere with three components each. `neighbours`: all with surfaces nearer than twice the
  /// reach.
  void add(const Grid& grid, const Decomposition& decomposition, int component, const Vec3& centre,
           double radius, std::span<const SphereNeighbour> neighbours = {});

  /// gain += what the points around sphere number `n` give in a time `dt` [T] when it
  /// moves as `motion` says. Returns the moment that the fluid gets of it about the sphere's
  /// centre, velocity times cells times length. The velocity's ghosts near the sphere are valid;
  /// what the gain's get stands for the points behind them.
  Vec3 find(std::size_t n, const SphereState& motion, const Grid& grid, double dt,
            const Field<Real>& velocity, Field<Real>& gain) const;

  /// Marks this rank's points around a sphere that its own correction may reach. In a dense bed the
  /// surroundings of spheres overlap many times; what is marked is given once.
  void mark(const Vec3& centre, double radius, const Grid& grid,
            const Decomposition& decomposition);

  /// velocity += gain, and gain = 0, at the points that are marked, which none is afterwards. Both
  /// fields have the same rows, ghosts apart.
  void give(Field<Real>& gain, Field<Real>& velocity);

 private:
  /// Points begin .. begin + count - 1 of row (j, k) of a component.
  struct Row {
    int j, k, component, begin, count;
    int x_from, x_to;       ///< those of the points that have both neighbours along x
    bool y_inner, z_inner;  ///< whether they have both along y, and z
    Vec3 first_place;       ///< of the first point, from the sphere's centre [L]
  };

  /// A plane between a sphere and a neighbour: the points x from its centre with way.x < bound are
  /// the sphere's.
  struct Plane {
    Vec3 way;
    double bound;
  };

  void find_planes(const Grid& grid, double radius, std::span<const SphereNeighbour> neighbours);
  void find_own_parts(double y);
  void add_row(const Row& start, const PointsAlong& x, const std::array<double, 2>& part);
  static std::array<std::array<Real, 2>, 3> factors(const Row& row, const SphereState& motion,
                                                    double scale);
  using Vector = WideVector<Real>;
  static constexpr int lanes = wide_width<Real>;
  /// One sum per lane, in double.
  using Sums [[gnu::vector_size(lanes * sizeof(double))]] = double;
  using Unsigned = std::conditional_t<sizeof(Real) == 8, std::uint64_t, std::uint32_t>;
  using Numbers [[gnu::vector_size(register_bytes)]] = Unsigned;
  static double total(const Sums& sums) {
    double all = 0.0;
    for (int n = 0; n < lanes; ++n) all += sums[n];
    return all;
  }

  static constexpr std::size_t rows_ahead = 6;  ///< that are asked for before their turn

  std::vector<Row> rows_;
  std::vector<std::size_t> begins_;  ///< first row of each sphere's component
  std::vector<Plane> planes_;        ///< of the sphere that is being added
  /// Of its rows in one plane: places along z, half of their chords within reach (negative: none),
  /// and the ends of the parts that are its own [L].
  std::vector<double> z_, half_chord_, from_, to_;

  /// A bit for each register's worth of points of a row, rows one after the other, plane by plane.
  static constexpr int bits = 64;
  std::vector<std::uint64_t> marks_;
  int marked_rows_ = 0;  ///< of a plane
  int words_in_row_ = 0;
};

template <class Real>
void DispersionCorrection<Real>::add(const Grid& grid, const Decomposition& decomposition,
                                     int component, const Vec3& centre, double radius,
                                     std::span<const SphereNeighbour> neighbours) {
  begins_.push_back(rows_.size());
  const auto line = [&](int d) { return PointsAlong{stencil_axis(grid, component, d), centre[d]}; };
  const PointsAlong x = line(0), y = line(1), z = line(2);
  const double reach = radius + dispersion_reach * grid.h;
  if (component == 0) find_planes(grid, radius, neighbours);
  const auto [lowest, highest] = y.within(reach);
  const auto [back, front] = z.within(reach);
  z_.clear();
  for (int k = back; k <= front; ++k) z_.push_back(z.place(k));
  half_chord_.resize(z_.size());
  // Whether the volumes around both neighbours along y are cubes, too; else what one of them gets
  // and the other loses would be no momentum.
  const int cubes = grid.cubic_planes(), volume_ends = component == 1 ? 2 : 1;
  const auto even = [&](int j) { return cubes == grid.cells[1] || j + volume_ends < cubes; };
  for (int j = lowest; j <= highest; ++j) {
    if (!decomposition.holds_plane(y.wrapped(j))) continue;
    const double disc = reach * reach - y.place(j) * y.place(j);
    for (std::size_t n = 0; n < z_.size(); ++n) {
      const double chord = disc - z_[n] * z_[n];
      half_chord_[n] = chord < 0.0 ? -1.0 : std::sqrt(chord);
    }
    find_own_parts(y.place(j));
    for (int k = back; k <= front; ++k) {
      const auto n = static_cast<std::size_t>(k - back);
      if (from_[n] > to_[n] || !decomposition.holds_row(z.wrapped(k))) continue;
      add_row({.j = y.wrapped(j) - decomposition.first(),
               .k = z.wrapped(k) - decomposition.first_row(),
               .component = component,
               .begin = 0,
               .count = 0,
               .x_from = 0,
               .x_to = 0,
               .y_inner = y.inner(j) && even(j),
               .z_inner = z.inner(k),
               .first_place = Vec3(0.0, y.place(j), z_[n])},
              x, {from_[n], to_[n]});
    }
  }
}

/// From |x|^2 - S^2 < |x - way|^2 - S'^2. Points on a plane, as far as rounding can tell, are the
/// neighbour's if it is the first.
template <class Real>
void DispersionCorrection<Real>::find_planes(const Grid& grid, double radius,
                                             std::span<const SphereNeighbour> neighbours) {
  planes_.clear();
  const double own = radius + dispersion_reach * grid.h;
  for (const SphereNeighbour& other : neighbours) {
    const double theirs = other.radius + dispersion_reach * grid.h, distance = other.way.norm();
    const double middle = 0.5 * (other.way.squaredNorm() + own * own - theirs * theirs);
    const double margin = 1e-9 * grid.h * distance;
    if (middle - margin > own * distance) continue;  // beyond reach
    planes_.push_back({other.way, other.first ? middle - margin : middle + margin});
  }
}

/// The sphere's parts of the rows of a plane at `y` from its centre, cut off by all planes: plane
/// after plane, so that rows lie side by side in registers. Nothing is left where from > to.
template <class Real>
void DispersionCorrection<Real>::find_own_parts(double y) {
  const std::size_t rows = z_.size();
  from_.resize(rows);
  to_.resize(rows);
  const double *z = z_.data(), *half_chord = half_chord_.data();
  double *from = from_.data(), *to = to_.data();
  for (std::size_t n = 0; n < rows; ++n) from[n] = -half_chord[n], to[n] = half_chord[n];
  for (const auto& [way, bound] : planes_) {
    const double level = bound - way.y() * y, across = way.z(), along = way.x();
    const double per_along = 1.0 / along;
    if (along > 0.0) {
      BEDLOAD_INDEPENDENT_LOOP
      for (std::size_t n = 0; n < rows; ++n)
        to[n] = std::min(to[n], (level - across * z[n]) * per_along);
    } else if (along < 0.0) {
      BEDLOAD_INDEPENDENT_LOOP
      for (std::size_t n = 0; n < rows; ++n)
        from[n] = std::max(from[n], (level - across * z[n]) * per_along);
    } else {
      for (std::size_t n = 0; n < rows; ++n)
        if (level - across * z[n] < 0.0) to[n] = from[n] - 1.0;
    }
  }
}

/// A row through the seam of periodic x is two.
template <class Real>
void DispersionCorrection<Real>::add_row(const Row& start, const PointsAlong& x,
                                         const std::array<double, 2>& part) {
  const auto [first, last] = x.between(part[0], part[1]);
  for (int begin = first; begin <= last;) {
    Row row = start;
    row.begin = x.wrapped(begin);
    row.count = std::min(last - begin, x.axis.highest - row.begin) + 1;
    row.x_from = x.inner(row.begin) ? 0 : 1;
    row.x_to = std::max(row.x_from, x.inner(row.begin + row.count - 1) ? row.count : row.count - 1);
    row.first_place.x() = x.place(begin);
    begin += row.count;
    rows_.push_back(row);
  }
}

/// scale V_d at the row's first point, and what it gains by one cell along x.
template <class Real>
std::array<std::array<Real, 2>, 3> DispersionCorrection<Real>::factors(const Row& row,
                                                                       const SphereState& motion,
                                                                       double scale) {
  const Vec3 &at = row.first_place, &spin = motion.angular_velocity;
  const Vec3 turned(spin.y() * at.z() - spin.z() * at.y(), spin.z() * at.x() - spin.x() * at.z(),
                    spin.x() * at.y() - spin.y() * at.x());
  const Vec3 gained(0.0, spin.z(), -spin.y());  // per length along x
  const std::array<bool, 3> inner{true, row.y_inner, row.z_inner};
  std::array<std::array<Real, 2>, 3> factor{};
  for (int d = 0; d < 3; ++d)
    if (inner[static_cast<std::size_t>(d)])
      factor[static_cast<std::size_t>(d)] = {
          static_cast<Real>(scale * (motion.velocity[d] + turned[d])),
          static_cast<Real>(scale * gained[d])};
  return factor;
}

template <class Real>
Vec3 DispersionCorrection<Real>::find(std::size_t n, const SphereState& motion, const Grid& grid,
                                      double dt, const Field<Real>& velocity,
                                      Field<Real>& gain) const {
  const std::size_t end = 3 * n + 3 < begins_.size() ? begins_[3 * n + 3] : rows_.size();
  const Real h = static_cast<Real>(grid.h);
  const Real* velocity_origin = velocity.row(0, 0);
  Real* origin = gain.row(0, 0);
  const auto plane = static_cast<std::ptrdiff_t>(velocity.plane_size());
  Vector lane{};
  Numbers number{};
  for (int i = 0; i < lanes; ++i)
    number[i] = static_cast<Unsigned>(i), lane[i] = static_cast<Real>(i);
  std::array<std::array<Sums, 3>, 3> sums{};  // by component and direction
  for (std::size_t r = begins_[3 * n]; r < end; ++r) {
    const Row& row = rows_[r];
    const int count = row.count;
    const auto gain_of = [&](const Real* there) { return origin + (there - velocity_origin); };
    if (r + rows_ahead < end) {
      const Row& later = rows_[r + rows_ahead];
      const Real* next = velocity.row(later.j + 1, later.k, later.component) + later.begin;
      ask_for(next, static_cast<std::size_t>(later.count + lanes));
      ask_to_write(gain_of(next), static_cast<std::size_t>(later.count + lanes));
    }
    const auto start = [&](int k) { return velocity.row(row.j, k, row.component); };
    const Real *q = start(row.k), *back = start(row.k - 1), *front = start(row.k + 1);
    const Real *below = q - plane, *above = q + plane;
    Real *here = gain_of(q), *to_below = here - plane, *to_above = here + plane,
         *to_back = gain_of(back), *to_front = gain_of(front);
    const auto factor = factors(row, motion, dispersion_factor * dt / (12.0 * grid.h));
    const Real v_x = factor[0][0], v_y = factor[1][0], v_z = factor[2][0];
    const Real more_y = factor[1][1] * h, more_z = factor[2][1] * h;
    // from <= n < to in one comparison: what is below wraps to a large number.
    const auto within = [](const Numbers& n, int from, int to) {
      return n - static_cast<Unsigned>(from) < static_cast<Unsigned>(to - from);
    };
    const auto add = [](Real* to, const Vector& amount) { store(to, load_wide(to) + amount); };
    auto& [along_x, along_y, along_z] = sums[static_cast<std::size_t>(row.component)];
    // One point further than the row on either side, which get what its ends give along x; from
    // register to register as rows begin, so that none is cut by a cache line.
    for (int i = (row.begin - 1) & -lanes; i <= row.begin + count; i += lanes) {
      const Vector place = lane + static_cast<Real>(i - row.begin), none{};
      const Numbers n_th = number + static_cast<Unsigned>(i - row.begin);
      const Vector middle = load_wide(q + i), twice = middle + middle,
                   behind = load_wide(q + i - 1), ahead = load_wide(q + i + 1);
      const Vector from_behind = within(n_th, row.x_from + 1, row.x_to + 1)
                                     ? v_x * (load_wide(q + i - 2) - (behind + behind) + middle)
                                     : none;
      const Vector from_ahead = within(n_th, row.x_from - 1, row.x_to - 1)
                                    ? v_x * (middle - (ahead + ahead) + load_wide(q + i + 2))
                                    : none;
      const auto inside = within(n_th, 0, count);
      const Vector y =
          inside ? (v_y + more_y * place) * (load_wide(below + i) - twice + load_wide(above + i))
                 : none;
      const Vector z =
          inside ? (v_z + more_z * place) * (load_wide(back + i) - twice + load_wide(front + i))
                 : none;
      add(here + i, from_ahead - from_behind);
      add(to_below + i, y);
      add(to_above + i, -y);
      add(to_back + i, z);
      add(to_front + i, -z);
      along_x += __builtin_convertvector(from_ahead, Sums);
      along_y += __builtin_convertvector(y, Sums);
      along_z += __builtin_convertvector(z, Sums);
    }
  }
  // (r cross f)_a = r_b f_c, (r cross f)_b = -r_a f_c; a point gives -D ahead and +D behind.
  Vec3 moment = Vec3::Zero();
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    const auto& of_component = sums[static_cast<std::size_t>(c)];
    moment[a] -= 2.0 * grid.h * total(of_component[static_cast<std::size_t>(b)]);
    moment[b] += 2.0 * grid.h * total(of_component[static_cast<std::size_t>(a)]);
  }
  return moment;
}

// Points of cells, whose faces are half a cell further; one cell more for the neighbours' gain.
template <class Real>
void DispersionCorrection<Real>::mark(const Vec3& centre, double radius, const Grid& grid,
                                      const Decomposition& decomposition) {
  const auto line = [&](int d) { return stencil_axis(grid, (d + 1) % 3, d); };
  const double reach = radius + (dispersion_reach + 1.5) * grid.h;
  marked_rows_ = decomposition.rows();
  words_in_row_ = (grid.cells[0] - 1) / (lanes * bits) + 1;
  const auto mark_run = [&](int j, int k, int first, int end, const Vec3&) {
    const std::size_t row = (static_cast<std::size_t>(j) * static_cast<std::size_t>(marked_rows_) +
                             static_cast<std::size_t>(k)) *
                            static_cast<std::size_t>(words_in_row_);
    if (row >= marks_.size())  // whole planes
      marks_.resize(static_cast<std::size_t>(j + 1) * static_cast<std::size_t>(marked_rows_) *
                    static_cast<std::size_t>(words_in_row_));
    for (int n = first / lanes; n <= (end - 1) / lanes; ++n)
      marks_[row + static_cast<std::size_t>(n / bits)] |= std::uint64_t{1} << (n % bits);
  };
  for_runs_within({line(0), line(1), line(2)}, decomposition, centre, reach, mark_run);
}

template <class Real>
void DispersionCorrection<Real>::give(Field<Real>& gain, Field<Real>& velocity) {
  std::size_t word = 0;
  const auto give_marked = [&](int j, int k, int n, std::uint64_t marked) {
    for (int c = 0; c < 3; ++c) {
      Real *u = velocity.row(j, k, c), *more = gain.row(j, k, c);
      for (std::uint64_t left = marked; left != 0; left &= left - 1) {
        const int i = (n * bits + std::countr_zero(left)) * lanes;
        store(u + i, load_wide(u + i) + load_wide(more + i));
        store(more + i, Vector{});
      }
    }
  };
  for (int j = 0; word < marks_.size(); ++j)
    for (int k = 0; k < marked_rows_; ++k)
      for (int n = 0; n < words_in_row_; ++n, ++word)
        if (marks_[word] != 0) give_marked(j, k, n, std::exchange(marks_[word], 0));
}

}  // namespace bedload
