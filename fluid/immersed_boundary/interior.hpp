#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/kernels/prefetch.hpp"
#include "fluid/kernels/simd.hpp"

namespace bedload {

/// Sums over the cells of one velocity component u, weighted by the share alpha of each cell that
/// lies inside a sphere; x are the two coordinates from its centre that are not along u, in the
/// order (component + 1) mod 3, (component + 2) mod 3.
struct InteriorSums {
  double cells = 0.0;          ///< sum alpha
  double u = 0.0;              ///< sum alpha u
  std::array<double, 2> x{};   ///< sum alpha x
  std::array<double, 2> xx{};  ///< sum alpha x^2
  std::array<double, 2> xu{};  ///< sum alpha x u
};

/// Corners of cells along x, an edge of a row of cells each: the distance phi = |x - x_p| - R of
/// each corner from a sphere's surface, and of two edges, one above the other, the sums of phi and
/// |phi|.
struct CornerLines {
  std::size_t corners = 0;  ///< of an edge, a multiple of 8
  std::size_t width = 0;    ///< stored, as a block of cells may reach beyond the last one
  std::vector<double> x_squared, phi, sum, size;

  void resize(std::size_t wanted, std::size_t lines) {
    corners = (wanted + 7) / 8 * 8;
    width = (wanted + simd_width + 7) / 8 * 8;
    x_squared.resize(corners);
    for (std::vector<double>* of_lines : {&phi, &sum, &size}) of_lines->resize(lines * width);
  }
  /// Goes on to the edge above; `across` = y^2 + z^2 there.
  void rise(std::size_t line, double across, double radius) {
    using Eight = Eigen::Array<double, 8, 1>;
    for (std::size_t i = 0, n = line * width; i < corners; i += 8, n += 8) {
      Eigen::Map<Eight> here(&phi[n]), both(&sum[n]), sizes(&size[n]);
      const Eight above = (across + Eigen::Map<const Eight>(&x_squared[i])).sqrt() - radius;
      both = here + above;
      sizes = here.abs() + above.abs();
      here = above;
    }
  }
  /// Shares of simd_width cells of a row, the edges `line` and `line + 1`, from corner `first` on
  /// (Kempe and Froehlich, J. Comput. Phys. 231 (2012), eq. 32, over a cell's eight corners):
  ///
  ///   alpha = sum_m -phi_m H(-phi_m) / sum_m |phi_m| = (1 - sum_m phi_m / sum_m |phi_m|)/2,
  ///
  /// H the Heaviside function.
  [[gnu::always_inline]] SimdVector<double> shares(std::size_t line, std::size_t first) const {
    const auto of_cells = [&](const std::vector<double>& of_lines) __attribute__((always_inline)) {
      const double *back = &of_lines[line * width + first], *front = back + width;
      return (load(back) + load(back + 1)) + (load(front) + load(front + 1));
    };
    return 0.5 - 0.5 * of_cells(sum) / of_cells(size);
  }
};

/// The cells of the velocity components inside spheres that lie in this block, with their shares:
/// found once for a place of the spheres, summed over as often as wanted.
class InteriorCells {
 public:
  void clear() {
    rows_.clear();
    shares_.clear();
    pairs_.clear();
  }

  /// Adds the cells of one component inside one sphere; `field` only tells the layout.
  template <class Real>
  void add(const Field<Real>& field, const Grid& grid, const Decomposition& decomposition,
           int component, const Vec3& centre, double radius);

  /// The sums over pair number `n`.
  template <class Real>
  InteriorSums sums(std::size_t n, const Field<Real>& velocity) const;

 private:
  /// A row of cells, in blocks of simd_width; those behind the last one have no share.
  struct Row {
    std::int32_t first;  ///< from row(0, 0, 0), as markers keep it
    std::int32_t blocks;
    double x, y, z;  ///< of the first cell's value, from the centre [L]
  };
  struct Pair {
    std::size_t begin, end;  ///< rows
    std::size_t share;       ///< place of the first share
    int component;
    InteriorSums shape;  ///< the sums without u
  };
  /// Sums of weights w, x w, y w and z w over cells, a lane each.
  struct Moments {
    SimdVector<double> all{}, x{}, y{}, z{};
    [[gnu::always_inline]] void add_row(const SimdVector<double>& w, const SimdVector<double>& xw,
                                        double at_y, double at_z) {
      all += w;
      x += xw;
      y += at_y * w;
      z += at_z * w;
    }
    /// The two directions that are not along the component.
    std::array<double, 2> across(int component) const {
      const std::array<double, 3> sums{sum_of(x), sum_of(y), sum_of(z)};
      return {sums[static_cast<std::size_t>(component + 1) % 3],
              sums[static_cast<std::size_t>(component + 2) % 3]};
    }
  };
  SimdVector<double> places(const Row& row) const { return row.x + h_ * number; }
  static constexpr SimdVector<double> number{0.0, 1.0, 2.0, 3.0};
  static constexpr std::size_t rows_ahead = 6;  ///< that are asked for before their turn

  double h_ = 0.0;
  std::vector<Row> rows_;
  std::vector<double> shares_;
  std::vector<Pair> pairs_;
  CornerLines corners_;
  std::vector<double> nearest_z_;    ///< of each row, squared distance of its nearest point [L^2]
  std::vector<double> half_chords_;  ///< of each row of a plane, in cells
};

template <class Real>
void InteriorCells::add(const Field<Real>& field, const Grid& grid,
                        const Decomposition& decomposition, int component, const Vec3& centre,
                        double radius) {
  const double h = h_ = grid.h;
  /// Distance of a cell's value from the sphere's centre along a direction, and of its lower face.
  const auto distance = [&](int direction, int cell) {
    return (direction == component ? grid.face(cell) : grid.centre(cell)) - centre[direction];
  };
  const auto lower = [&](int direction, int cell) { return distance(direction, cell) - 0.5 * h; };
  /// First and last cell whose box may be within the radius, and which exist.
  const auto cells_within = [&](int direction) {
    const double middle = (centre[direction] - (direction == component ? 1.0 : 0.5) * h) / h;
    std::array<int, 2> range{static_cast<int>(std::ceil(middle - radius / h - 0.5)),
                             static_cast<int>(std::floor(middle + radius / h + 0.5))};
    if (!grid.periodic(direction)) {
      const int last = grid.cells[static_cast<std::size_t>(direction)] - 1;
      range = {std::max(range[0], 0), std::min(range[1], last)};
    }
    return range;
  };
  // A sphere is smaller than the box.
  const auto wrapped = [&](int direction, int cell) {
    const int n = grid.cells[static_cast<std::size_t>(direction)];
    return cell < 0 ? cell + n : cell < n ? cell : cell - n;
  };
  const auto nearest_face = [h](double x) { return std::max(std::abs(x) - 0.5 * h, 0.0); };
  const auto square = [](double x) { return x * x; };

  const std::array<int, 2> along_x = cells_within(0), along_z = cells_within(2);
  const int left = along_x[0], right = std::max(along_x[1], left);
  const int back = along_z[0], front = std::max(along_z[1], back);
  corners_.resize(static_cast<std::size_t>(right - left + 2),
                  static_cast<std::size_t>(front - back + 2));
  for (std::size_t i = 0; i < corners_.corners; ++i)
    corners_.x_squared[i] = square(lower(0, left + static_cast<int>(i)));
  const auto line = [back](int k) { return static_cast<std::size_t>(k - back); };
  const auto row_here = [&](int k) { return decomposition.holds_row(wrapped(2, k)); };
  const auto rise_to = [&](int j) {
    for (int k = back; k <= front + 1; ++k) {
      const double across = square(lower(1, j)) + square(lower(2, k));
      // Only corners of cells that may be inside, and here.
      if (across > square(radius + 1.5 * h) || !(row_here(k - 1) || row_here(k))) continue;
      corners_.rise(line(k), across, radius);
    }
  };

  const int nx = grid.cells[0];
  const Real* origin = field.row(0, 0, 0);
  const double middle = (centre[0] - (component == 0 ? 1.0 : 0.5) * h) / h, per_cell = 1.0 / h;
  nearest_z_.clear();
  for (int k = back; k <= along_z[1]; ++k)
    nearest_z_.push_back(square(nearest_face(distance(2, k))));
  half_chords_.resize(nearest_z_.size());
  const std::size_t rows_before = rows_.size(), shares_before = shares_.size();
  Moments first, second;
  bool have_below = false;
  const auto [first_plane, last_plane] = cells_within(1);
  for (int j = first_plane; j <= last_plane; ++j) {
    const int plane = wrapped(1, j);
    const bool here = decomposition.holds_plane(plane);
    if (here && !have_below) rise_to(j);
    have_below = here;
    if (!here) continue;
    rise_to(j + 1);
    const double y = distance(1, j), disc = square(radius) - square(nearest_face(y));
    for (std::size_t n = 0; n < nearest_z_.size(); ++n)
      half_chords_[n] = std::sqrt(std::max(disc - nearest_z_[n], 0.0)) * per_cell;
    for (int k = back; k <= along_z[1]; ++k) {
      const double z = distance(2, k), half_chord = half_chords_[line(k)];
      if (half_chord <= 0.0 || !row_here(k)) continue;
      // The cells with a corner inside are among these.
      const int from = std::max(static_cast<int>(std::ceil(middle - half_chord - 0.5)), left),
                to = std::min(static_cast<int>(std::floor(middle + half_chord + 0.5)), along_x[1]);
      const Real* row = field.row(plane - decomposition.first(),
                                  wrapped(2, k) - decomposition.first_row(), component);
      // A row through the seam of periodic x is two.
      for (int begin = from; begin <= to;) {
        const int there = wrapped(0, begin), end = std::min(to + 1, begin + nx - there);
        const int blocks = (end - begin + simd_width - 1) / simd_width;
        rows_.push_back({.first = static_cast<std::int32_t>(row - origin + there),
                         .blocks = blocks,
                         .x = distance(0, begin),
                         .y = y,
                         .z = z});
        const std::size_t place = shares_.size();
        shares_.resize(place + static_cast<std::size_t>(blocks * simd_width));
        SimdVector<double> w{}, xw{}, xxw{}, x = places(rows_.back());
        for (int b = 0; b < blocks * simd_width; b += simd_width, x += simd_width * h) {
          const auto in_row = number < static_cast<double>(end - begin - b);
          const SimdVector<double> share =
              in_row ? corners_.shares(line(k), static_cast<std::size_t>(begin - left + b))
                     : SimdVector<double>{};
          store(&shares_[place + static_cast<std::size_t>(b)], share);
          w += share;
          xw += x * share;
          xxw += x * x * share;
        }
        first.add_row(w, xw, y, z);
        second.add_row(w, xxw, y * y, z * z);
        begin = end;
      }
    }
  }
  InteriorSums shape;
  shape.cells = sum_of(first.all);
  shape.x = first.across(component);
  shape.xx = second.across(component);
  pairs_.push_back({rows_before, rows_.size(), shares_before, component, shape});
}

template <class Real>
InteriorSums InteriorCells::sums(std::size_t n, const Field<Real>& velocity) const {
  const Pair& pair = pairs_[n];
  const Real* origin = velocity.row(0, 0, 0);
  const double* share = shares_.data() + pair.share;
  Moments moments;
  for (std::size_t r = pair.begin; r < pair.end; ++r) {
    const Row& row = rows_[r];
    if (r + rows_ahead < rows_.size()) {
      const Row& later = rows_[r + rows_ahead];
      ask_for(origin + later.first, static_cast<std::size_t>(later.blocks * simd_width));
    }
    const Real* u = origin + row.first;
    SimdVector<double> w{}, xw{}, x = places(row);
    for (int b = 0; b < row.blocks;
         ++b, x += simd_width * h_, u += simd_width, share += simd_width) {
      const SimdVector<double> inside = load(share) * load_double(u);
      w += inside;
      xw += x * inside;
    }
    moments.add_row(w, xw, row.y, row.z);
  }
  InteriorSums total = pair.shape;
  total.u = sum_of(moments.all);
  total.xu = moments.across(pair.component);
  return total;
}

/// Momentum and angular momentum about its centre of the fluid inside a sphere, per fluid density.
struct InteriorMomentum {
  Vec3 linear = Vec3::Zero();   ///< integral of u dV [L^4/T]
  Vec3 angular = Vec3::Zero();  ///< integral of (x - x_p) x u dV [L^5/T]
};

/// From the sums of the three components over all ranks. Each component is fitted by u = U + s.x,
/// and the exact volume and second moment of the sphere are put in,
///
///   int u_c dV = V U_c,   int x_d u_c dV = V R^2/5 s_cd,
///
/// so that the result is exact for a sphere's own motion wherever it lies between the cells (the
/// plain sums wander by a few parts in a thousand, which a time derivative would turn into noise).
inline InteriorMomentum interior_momentum(const std::array<InteriorSums, 3>& sums, double radius) {
  const double volume = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
  const double second = volume * radius * radius / 5.0;
  InteriorMomentum out;
  for (int c = 0; c < 3; ++c) {
    const InteriorSums& s = sums[static_cast<std::size_t>(c)];
    if (s.cells <= 0.0) continue;
    double at_centre = s.u / s.cells;
    std::array<double, 2> slope{};
    for (std::size_t d = 0; d < 2; ++d) {
      const double spread = s.xx[d] - s.x[d] * s.x[d] / s.cells;
      if (spread > 0.0) slope[d] = (s.xu[d] - s.x[d] * s.u / s.cells) / spread;
      at_centre -= slope[d] * s.x[d] / s.cells;
    }
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    out.linear[c] = volume * at_centre;
    out.angular[a] += second * slope[1];  // (x cross u)_a = x_b u_c - x_c u_b
    out.angular[b] -= second * slope[0];  // (x cross u)_b = x_c u_a - x_a u_c
  }
  return out;
}

}  // namespace bedload
