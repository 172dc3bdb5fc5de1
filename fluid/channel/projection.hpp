#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "fluid/kernels/independent_loop.hpp"

namespace bedload {

/// One row of in_plane * (u_i - u_i-1 + w_k - w_k-1) + upwards * (v_j - v_j-1): the outflow of
/// cells through their faces, whose areas are in the two factors.
template <class Real>
void divergence_row(int nx, Real in_plane, Real upwards, const Real* u, const Real* v,
                    const Real* v_below, const Real* w, const Real* w_back, Real* __restrict out) {
  for (int i = 0; i < nx; ++i)
    out[i] = in_plane * ((u[i] - u[i - 1]) + (w[i] - w_back[i])) + upwards * (v[i] - v_below[i]);
}

/// One row of u = u* - (2 alpha dt/h) (phi_i+1 - phi_i) + shift, and v, w alike without the shift:
/// the projection, with the bulk correction on top. `factor_y` has the distance along y in place of
/// h. Reads from_, writes to_, which may be the same.
template <class Real>
void correct_row(int nx, Real factor, Real factor_y, Real shift, std::size_t component,
                 const Real* from, Real* to, const Real* phi, const Real* phi_above,
                 const Real* phi_front) {
  const Real *u = from, *v = from + component, *w = v + component;
  Real *to_u = to, *to_v = to + component, *to_w = to_v + component;
  BEDLOAD_INDEPENDENT_LOOP
  for (int i = 0; i < nx; ++i) to_u[i] = u[i] - factor * (phi[i + 1] - phi[i]) + shift;
  BEDLOAD_INDEPENDENT_LOOP
  for (int i = 0; i < nx; ++i) to_v[i] = v[i] - factor_y * (phi_above[i] - phi[i]);
  BEDLOAD_INDEPENDENT_LOOP
  for (int i = 0; i < nx; ++i) to_w[i] = w[i] - factor * (phi_front[i] - phi[i]);
}

/// Sum of term(i), i = 0 .. nx - 1, in double, in eight interleaved parts: independent of how it is
/// vectorised.
template <class Term>
double row_total(int nx, const Term& term) {
  constexpr int parts = 8;
  double sum[parts] = {};
  int i = 0;
  for (; i + parts <= nx; i += parts)
    for (int n = 0; n < parts; ++n) sum[n] += term(i + n);
  for (; i < nx; ++i) sum[0] += term(i);
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

/// Sum of a row in double.
template <class Real>
double row_sum(int nx, const Real* row) {
  return row_total(nx, [row](int i) { return static_cast<double>(row[i]); });
}

/// Largest |u| + stretch |v| + |w| of a row, `stretch` being h over the height of its cells (NaN
/// does not show here; sums show it).
template <class Real>
Real largest_speed(int nx, Real stretch, std::size_t component, const Real* row) {
  constexpr int parts = 8;
  const Real *u = row, *v = row + component, *w = v + component;
  Real largest[parts] = {};
  const auto speed = [&](int i) {
    return std::abs(u[i]) + stretch * std::abs(v[i]) + std::abs(w[i]);
  };
  int i = 0;
  for (; i + parts <= nx; i += parts)
    for (int n = 0; n < parts; ++n) {
      const Real s = speed(i + n);
      largest[n] = s > largest[n] ? s : largest[n];
    }
  for (; i < nx; ++i) largest[0] = std::max(largest[0], speed(i));
  return *std::max_element(largest, largest + parts);
}

}  // namespace bedload
