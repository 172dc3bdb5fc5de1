#pragma once

#include <cstddef>

#include "fluid/independent_loop.hpp"

namespace bedload {

/// Numbers of one Runge-Kutta stage in the momentum predictor, in the precision of the fields.
template <class Real>
struct MomentumFactors {
  Real convection;  ///< 1/(4h): each face value is a mean of two, and so is each face velocity
  Real diffusion;   ///< nu/h^2; 2 alpha dt nu/h^2 if diffusion is implicit
  Real gamma_dt;    ///< weight of the present tendency
  Real zeta_dt;     ///< weight of the tendency of the stage before
  Real pressure;    ///< 2 alpha dt/h
};

/// What stretched y changes for the points of one plane; all ones on cubes.
template <class Real>
struct PlaneMetric {
  Real height = 1;  ///< h over the height of the volume around the point
  Real above = 1;   ///< times h over the distance to the point above
  Real below = 1;   ///< and below
  Real here = 1,
       next = 1;  ///< of v: share of the cell below and above the face in its volume, twice
};

/// Which terms a predictor loop holds; each combination is compiled on its own.
template <bool HasConvection, bool HasPressure, bool HasOld, bool KeepsTendency, bool IsStretched,
          bool IsImplicit>
struct Terms {
  static constexpr bool stretched = IsStretched;
  static constexpr bool implicit = IsImplicit;
  static constexpr bool convection = HasConvection;
  static constexpr bool pressure = HasPressure;  ///< the old pressure gradient
  static constexpr bool old = HasOld;            ///< the tendency of the stage before
  static constexpr bool keep = KeepsTendency;    ///< leaves the tendency for the next stage
};

/// One row of one velocity component q:
///
///   N  = -[ (a q)_east - (a q)_west + (b q)_north - (b q)_south + (c q)_front - (c q)_back ] / h
///        + nu [ q_i-1 + q_i+1 + q_below + q_above + q_back + q_front - 6 q ] / h^2
///   q* = q + gamma dt N + zeta dt N_old + push - 2 alpha dt (p_next - p_here) / h
///
/// with face values of q and of the advecting velocity a, b, c as means of their two neighbours:
/// a = (a1 + a2)/2 at the east face of cell i, the west face being the east face of cell i-1. This
/// divergence form conserves momentum, and kinetic energy where the discrete divergence is zero
/// (Harlow & Welch 1965; Morinishi et al., J. Comput. Phys. 143 (1998) 90, eq. (70)).
///
/// On stretched y the volume around q is 1/height times h high, the distances to the points above
/// and below enter diffusion, and the mean of a1, a2 for v's volume weighs its two half cells by
/// their height, so that each volume's own flux balances: momentum and energy are kept as on cubes
/// (Verstappen & Veldman, J. Comput. Phys. 187 (2003) 343).
///
/// With implicit diffusion N is convection alone, and what is computed is the right-hand side for
/// the increment d = q* - q, which needs no wall values of its own:
///
///   d - after dt nu L d = gamma dt N + zeta dt N_old + push - 2 alpha dt grad p + 2 alpha dt nu L
///   q
///
/// The result goes to `out`, which may be `below` or `above`. `tendency` holds N_old and then N.
/// `ahead` and `tendency_ahead` are the same component of the rows that the sweep comes to next; a
/// few cache lines of them are asked for before each piece of this row.
template <class Term, bool weighted, class Real>
[[gnu::always_inline]] inline void predict_row(
    int nx, const MomentumFactors<Real>& factor, const PlaneMetric<Real>& y, Real push,
    const Real* q, const Real* below, const Real* above, const Real* back, const Real* front,
    const Real* a1, const Real* a2, const Real* b1, const Real* b2, const Real* b1_south,
    const Real* b2_south, const Real* c1, const Real* c2, const Real* c1_back, const Real* c2_back,
    Real* tendency, const Real* p_here, const Real* p_next, const Real* ahead,
    const Real* tendency_ahead, Real* out) {
  const Real convection = factor.convection, diffusion = factor.diffusion;
  const Real gamma_dt = factor.gamma_dt, zeta_dt = factor.zeta_dt;
  const Real pressure = weighted && Term::stretched ? factor.pressure * y.height : factor.pressure;
  const Real height = y.height, to_above = y.above, to_below = y.below;
  const Real half_here = y.here, half_next = y.next;
  // The advecting velocity, twice: over v's volume it is weighted by the half cells' heights.
  const auto twice = [=](Real here, Real next) {
    if constexpr (weighted && Term::stretched)
      return half_here * here + half_next * next;
    else
      return here + next;
  };
  constexpr int line = 64 / sizeof(Real), piece = 4 * line;
  for (int begin = 0; begin < nx; begin += piece) {
    const int end = begin + piece < nx ? begin + piece : nx;
    for (int i = begin; i < end; i += line) {
      __builtin_prefetch(ahead + i, 0);
      if constexpr (Term::old || Term::keep) __builtin_prefetch(tendency_ahead + i, 1);
    }
    BEDLOAD_INDEPENDENT_LOOP
    for (int i = begin; i < end; ++i) {
      Real laplacian;
      if constexpr (Term::stretched)
        laplacian = (q[i - 1] + q[i + 1]) + (back[i] + front[i]) - Real(4) * q[i] +
                    (to_above * (above[i] - q[i]) - to_below * (q[i] - below[i]));
      else
        laplacian =
            (q[i - 1] + q[i + 1]) + (below[i] + above[i]) + (back[i] + front[i]) - Real(6) * q[i];
      Real n = Term::implicit ? Real(0) : diffusion * laplacian;
      if constexpr (Term::convection) {
        const Real east = twice(a1[i], a2[i]) * (q[i] + q[i + 1]);
        const Real west = twice(a1[i - 1], a2[i - 1]) * (q[i - 1] + q[i]);
        const Real north = (b1[i] + b2[i]) * (q[i] + above[i]);
        const Real south = (b1_south[i] + b2_south[i]) * (below[i] + q[i]);
        const Real forward = twice(c1[i], c2[i]) * (q[i] + front[i]);
        const Real backward = twice(c1_back[i], c2_back[i]) * (back[i] + q[i]);
        const Real upwards = Term::stretched ? height * (north - south) : north - south;
        n -= convection * ((east - west) + upwards + (forward - backward));
      }
      Real result = (Term::implicit ? diffusion * laplacian : q[i]) + gamma_dt * n + push;
      if constexpr (Term::old) result += zeta_dt * tendency[i];
      if constexpr (Term::keep) tendency[i] = n;
      if constexpr (Term::pressure) result -= pressure * (p_next[i] - p_here[i]);
      out[i] = result;
    }
  }
}

/// The rows that the predictor of cell row (j, k) reads; u, v and w lie `component` values apart.
template <class Real>
struct MomentumRows {
  std::size_t component;
  const Real* here;                    ///< (j, k)
  const Real* above;                   ///< (j+1, k)
  const Real* below;                   ///< (j-1, k)
  const Real* back;                    ///< (j, k-1)
  const Real* front;                   ///< (j, k+1)
  const Real* w_above_back;            ///< w of (j+1, k-1), as it was before the sweep
  const Real* v_below_front;           ///< v of (j-1, k+1), likewise
  Real* tendency;                      ///< (j, k), three components
  const Real *ahead, *tendency_ahead;  ///< velocity and tendency of rows that come later
  const Real *p, *p_above, *p_front;   ///< (j, k), (j+1, k), (j, k+1)
  Real* out[3];                        ///< where u, v and w go
};

/// The predictors of u and w take the metric of the cells of plane j, that of v the metric of their
/// upper faces.
template <class Term, class Real>
[[gnu::noinline]] void predict_u(int nx, const MomentumFactors<Real>& factor,
                                 const PlaneMetric<Real>& y, Real push,
                                 const MomentumRows<Real>& r) {
  const Real *u = r.here, *v = u + r.component, *w = v + r.component;
  const Real *v_below = r.below + r.component, *w_back = r.back + 2 * r.component;
  predict_row<Term, false>(nx, factor, y, push, u, r.below, r.above, r.back, r.front, u, u + 1, v,
                           v + 1, v_below, v_below + 1, w, w + 1, w_back, w_back + 1, r.tendency,
                           r.p, r.p + 1, r.ahead, r.tendency_ahead, r.out[0]);
}

template <class Term, class Real>
[[gnu::noinline]] void predict_v(int nx, const MomentumFactors<Real>& factor,
                                 const PlaneMetric<Real>& y, Real push,
                                 const MomentumRows<Real>& r) {
  const std::size_t c = r.component;
  const Real *u = r.here, *v = u + c, *w = v + c;
  predict_row<Term, true>(nx, factor, y, push, v, r.below + c, r.above + c, r.back + c, r.front + c,
                          u, r.above, v, r.above + c, r.below + c, v, w, r.above + 2 * c,
                          r.back + 2 * c, r.w_above_back, r.tendency + c, r.p, r.p_above,
                          r.ahead + c, r.tendency_ahead + c, r.out[1]);
}

template <class Term, class Real>
[[gnu::noinline]] void predict_w(int nx, const MomentumFactors<Real>& factor,
                                 const PlaneMetric<Real>& y, Real push,
                                 const MomentumRows<Real>& r) {
  const std::size_t c = r.component;
  const Real *u = r.here, *v = u + c, *w = v + c;
  const Real *w_front = r.front + 2 * c, *w_back = r.back + 2 * c;
  predict_row<Term, false>(nx, factor, y, push, w, r.below + 2 * c, r.above + 2 * c, w_back,
                           w_front, u, r.front, v, r.front + c, r.below + c, r.v_below_front, w,
                           w_front, w_back, w, r.tendency + 2 * c, r.p, r.p_front, r.ahead + 2 * c,
                           r.tendency_ahead + 2 * c, r.out[2]);
}

/// One row of all three components. The order matters: a result that overwrites the row below takes
/// away the v that the predictors of u and w need, one that overwrites the row above the u and w
/// that the predictor of v needs.
template <class Term, class Real>
void predict_velocity(int nx, const MomentumFactors<Real>& factor, const PlaneMetric<Real>& cell,
                      const PlaneMetric<Real>& face, const Real (&push)[3],
                      const MomentumRows<Real>& rows) {
  const bool over_above = rows.out[0] == rows.above;
  if (over_above) predict_v<Term>(nx, factor, face, push[1], rows);
  predict_u<Term>(nx, factor, cell, push[0], rows);
  predict_w<Term>(nx, factor, cell, push[2], rows);
  if (!over_above) predict_v<Term>(nx, factor, face, push[1], rows);
}

}  // namespace bedload
