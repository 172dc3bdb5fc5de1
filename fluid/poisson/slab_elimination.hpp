#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "fluid/poisson/y_row.hpp"

namespace bedload {

/// What couples a slab, once eliminated, to the planes X of its neighbours (see eliminate_slab).
struct SlabCoupling {
  double c = 0.0;      ///< of the last plane to the plane above the slab
  double f = 0.0;      ///< of the last plane to the plane below the slab
  double alpha = 0.0;  ///< of the first plane to the plane below the slab
  double beta = 0.0;   ///< of the first plane to the last plane
};

/// Numbers of one plane that turn its right-hand side into d' (see eliminate_slab).
struct PlaneFactors {
  double own = 1.0;     ///< 1/u_j
  double before = 1.0;  ///< l_j/u_j
  double first = 1.0;   ///< t_j
};

/// Factors of the planes of a slab. Where nothing lies above, u_j = 1 takes its place.
inline std::vector<PlaneFactors> plane_factors(std::span<const YRow> rows) {
  std::vector<PlaneFactors> factors;
  double t = 1.0;
  for (const YRow& row : rows) {
    const double upper = row.upper != 0.0 ? row.upper : 1.0;
    factors.push_back({1.0 / upper, row.lower / upper, t});
    if (row.lower != 0.0) t *= upper / row.lower;
  }
  return factors;
}

/// Gaussian elimination, upwards, of many modes on a slab of planes 0 .. n-1,
///
///   l_j x_j-1 + b_j x_j + u_j x_j+1 = d_j,      b_j = diagonal_j + eigenvalue mass_j,
///
/// the plane below the slab, X = x_-1, being carried along as an unknown:
///
///   x_j = d'_j - c_j x_j+1 - f_j X,     c_j = u_j/(b_j - l_j c_j-1),
///   f_j = -c_j (l_j/u_j) f_j-1,         d'_j = c_j (d_j/u_j - (l_j/u_j) d'_j-1),
///   c_-1 = 0, d'_-1 = 0, f_-1 = -1 (0 above a wall, where l_0 = 0).
///
/// Going on with the rows j < n-1 gives the first plane in terms of X and the last one alone,
///
///   x_0 = g + alpha X + beta x_n-1,     g = - sum_{j<n-1} t_j f_j-1 d'_j,
///   alpha = sum_{j<n-1} t_j f_j-1 f_j,  beta = -t_n-1 f_n-2,     t_j = prod_{i<j} u_i/l_i,
///
/// because -t_j f_j-1 is the product of -c_0 .. -c_j-1. `store(j, c, f)` gets the arrays of plane
/// j. A row without mass says x = 0 (y_row.hpp): c = 0 there. Between two walls mode `open` (the
/// mean one) has a last pivot of zero; c = 0 there fixes the last plane at zero.
template <class Store>
void eliminate_slab(std::span<const YRow> rows, std::span<const double> eigenvalue,
                    std::size_t open, Store&& store, std::span<SlabCoupling> coupling) {
  const std::vector<PlaneFactors> factors = plane_factors(rows);
  const std::size_t modes = eigenvalue.size(), planes = rows.size();
  const bool closed = rows.front().lower == 0.0 && rows.back().upper == 0.0;
  const double begin = rows.front().lower != 0.0 ? -1.0 : 0.0;
  std::vector<double> c(modes, 0.0), f(modes, begin), alpha(modes, 0.0), beta(modes, -begin);
  for (std::size_t j = 0; j < planes; ++j) {
    const YRow& row = rows[j];
    const PlaneFactors& factor = factors[j];
    const double upper = 1.0 / factor.own;
    const bool last = j + 1 == planes;
    if (last)
      for (std::size_t m = 0; m < modes; ++m) beta[m] = -factor.first * f[m];
    for (std::size_t m = 0; m < modes; ++m) {
      const double next =
          row.mass == 0.0 ? 0.0
                          : upper / (row.diagonal + eigenvalue[m] * row.mass - row.lower * c[m]);
      // An error of c falls by c^2 from plane to plane. What is at its fixed point to round-off
      // stays there, so that it need not be kept again for each plane (mode_coefficients.hpp).
      const double left = std::abs(next - c[m]) / (1.0 - std::min(next * next, 1.0));
      if (!(left <= std::numeric_limits<double>::epsilon() * std::abs(next))) c[m] = next;
    }
    if (last && open < modes && closed) c[open] = 0.0;
    for (std::size_t m = 0; m < modes; ++m) {
      const double before = f[m];
      f[m] = -c[m] * factor.before * before;
      alpha[m] += last ? 0.0 : factor.first * before * f[m];
    }
    store(j, c.data(), f.data());
  }
  const bool open_above = rows.back().upper != 0.0;
  for (std::size_t m = 0; m < modes; ++m)
    coupling[m] = {open_above ? c[m] : 0.0, f[m], alpha[m], beta[m]};
}

}  // namespace bedload
