#pragma once

#include <cstddef>

#include "fluid/independent_loop.hpp"

namespace bedload {

/// Numbers of one Runge-Kutta stage in the momentum predictor, in the precision of the fields.
template <class Real>
struct MomentumFactors {
  Real convection;  ///< 1/(4h): each face value is a mean of two, and so is each face velocity
  Real diffusion;   ///< nu/h^2
  Real gamma_dt;    ///< weight of the present tendency
  Real zeta_dt;     ///< weight of the tendency of the stage before
  Real pressure;    ///< 2 alpha dt/h
};

/// Which terms a predictor loop holds; each combination is compiled on its own.
template <bool HasConvection, bool HasPressure, bool HasOld, bool KeepsTendency>
struct Terms {
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
/// `below` holds q of the plane below on entry and q* on return; `tendency` holds N_old and then N.
/// `ahead` and `tendency_ahead` are the same component of the rows that the sweep comes to next; a
/// few cache lines of them are asked for before each piece of this row.
template <class Term, class Real>
[[gnu::always_inline]] inline void predict_row(
    int nx, const MomentumFactors<Real>& factor, Real push, const Real* q, Real* below,
    const Real* above, const Real* back, const Real* front, const Real* a1, const Real* a2,
    const Real* b1, const Real* b2, const Real* b1_south, const Real* b2_south, const Real* c1,
    const Real* c2, const Real* c1_back, const Real* c2_back, Real* tendency, const Real* p_here,
    const Real* p_next, const Real* ahead, const Real* tendency_ahead) {
  const Real convection = factor.convection, diffusion = factor.diffusion;
  const Real gamma_dt = factor.gamma_dt, zeta_dt = factor.zeta_dt, pressure = factor.pressure;
  constexpr int line = 64 / sizeof(Real), piece = 4 * line;
  for (int begin = 0; begin < nx; begin += piece) {
    const int end = begin + piece < nx ? begin + piece : nx;
    for (int i = begin; i < end; i += line) {
      __builtin_prefetch(ahead + i, 0);
      if constexpr (Term::old || Term::keep) __builtin_prefetch(tendency_ahead + i, 1);
    }
    BEDLOAD_INDEPENDENT_LOOP
    for (int i = begin; i < end; ++i) {
      Real n = diffusion * ((q[i - 1] + q[i + 1]) + (below[i] + above[i]) + (back[i] + front[i]) -
                            Real(6) * q[i]);
      if constexpr (Term::convection) {
        const Real east = (a1[i] + a2[i]) * (q[i] + q[i + 1]);
        const Real west = (a1[i - 1] + a2[i - 1]) * (q[i - 1] + q[i]);
        const Real north = (b1[i] + b2[i]) * (q[i] + above[i]);
        const Real south = (b1_south[i] + b2_south[i]) * (below[i] + q[i]);
        const Real forward = (c1[i] + c2[i]) * (q[i] + front[i]);
        const Real backward = (c1_back[i] + c2_back[i]) * (back[i] + q[i]);
        n -= convection * ((east - west) + (north - south) + (forward - backward));
      }
      Real result = q[i] + gamma_dt * n + push;
      if constexpr (Term::old) result += zeta_dt * tendency[i];
      if constexpr (Term::keep) tendency[i] = n;
      if constexpr (Term::pressure) result -= pressure * (p_next[i] - p_here[i]);
      below[i] = result;
    }
  }
}

/// The rows that the predictor of cell row (j, k) reads; u, v and w lie `component` values apart.
template <class Real>
struct MomentumRows {
  std::size_t component;
  const Real* here;                    ///< (j, k)
  const Real* above;                   ///< (j+1, k)
  Real* below;                         ///< (j-1, k), where the result goes
  const Real* back;                    ///< (j, k-1)
  const Real* front;                   ///< (j, k+1)
  const Real* above_back;              ///< (j+1, k-1)
  const Real* v_below_front;           ///< v of (j-1, k+1), as it was before the sweep
  Real* tendency;                      ///< (j, k), three components
  const Real *ahead, *tendency_ahead;  ///< velocity (j+1, k+1), tendency (j, k+1)
  const Real *p, *p_above, *p_front;   ///< (j, k), (j+1, k), (j, k+1)
};

template <class Term, class Real>
[[gnu::noinline]] void predict_u(int nx, const MomentumFactors<Real>& factor, Real push,
                                 const MomentumRows<Real>& r) {
  const Real *u = r.here, *v = u + r.component, *w = v + r.component;
  const Real *v_below = r.below + r.component, *w_back = r.back + 2 * r.component;
  predict_row<Term>(nx, factor, push, u, r.below, r.above, r.back, r.front, u, u + 1, v, v + 1,
                    v_below, v_below + 1, w, w + 1, w_back, w_back + 1, r.tendency, r.p, r.p + 1,
                    r.ahead, r.tendency_ahead);
}

template <class Term, class Real>
[[gnu::noinline]] void predict_v(int nx, const MomentumFactors<Real>& factor, Real push,
                                 const MomentumRows<Real>& r) {
  const std::size_t c = r.component;
  const Real *u = r.here, *v = u + c, *w = v + c;
  predict_row<Term>(nx, factor, push, v, r.below + c, r.above + c, r.back + c, r.front + c, u,
                    r.above, v, r.above + c, r.below + c, v, w, r.above + 2 * c, r.back + 2 * c,
                    r.above_back + 2 * c, r.tendency + c, r.p, r.p_above, r.ahead + c,
                    r.tendency_ahead + c);
}

template <class Term, class Real>
[[gnu::noinline]] void predict_w(int nx, const MomentumFactors<Real>& factor, Real push,
                                 const MomentumRows<Real>& r) {
  const std::size_t c = r.component;
  const Real *u = r.here, *v = u + c, *w = v + c;
  const Real *w_front = r.front + 2 * c, *w_back = r.back + 2 * c;
  predict_row<Term>(nx, factor, push, w, r.below + 2 * c, r.above + 2 * c, w_back, w_front, u,
                    r.front, v, r.front + c, r.below + c, r.v_below_front, w, w_front, w_back, w,
                    r.tendency + 2 * c, r.p, r.p_front, r.ahead + 2 * c, r.tendency_ahead + 2 * c);
}

/// One row of all three components. The order matters: the result overwrites the row below, whose v
/// the predictors of u and w still need.
template <class Term, class Real>
void predict_velocity(int nx, const MomentumFactors<Real>& factor, const Real (&push)[3],
                      const MomentumRows<Real>& rows) {
  predict_u<Term>(nx, factor, push[0], rows);
  predict_w<Term>(nx, factor, push[2], rows);
  predict_v<Term>(nx, factor, push[1], rows);
}

}  // namespace bedload
