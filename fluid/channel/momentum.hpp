#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "fluid/kernels/past_caches.hpp"
#include "fluid/kernels/simd.hpp"

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
  Real above = 1;   ///< h over the distance to the point above
  Real below = 1;   ///< and below
  Real here = 1,
       next = 1;  ///< of v: share of the cell below and above the face in its volume, twice
};

/// Which terms a predictor loop holds; each combination is compiled on its own.
template <bool HasConvection, bool HasPressure, bool HasOld, bool KeepsTendency, bool IsStretched,
          bool IsImplicit, bool KeepsPastCaches = false>
struct Terms {
  static constexpr bool stretched = IsStretched;
  static constexpr bool implicit = IsImplicit;
  static constexpr bool convection = HasConvection;
  static constexpr bool pressure = HasPressure;         ///< the old pressure gradient
  static constexpr bool old = HasOld;                   ///< the tendency of the stage before
  static constexpr bool keep = KeepsTendency;           ///< leaves the tendency for the next stage
  static constexpr bool past_caches = KeepsPastCaches;  ///< where that goes, if nothing is old
};

/// The rows that the predictor of cell row (j, k) reads and writes, u, v and w each.
template <class Real>
struct MomentumRows {
  std::size_t component;               ///< distance between u, v and w of a row, but for `out`
  const Real* here;                    ///< (j, k)
  const Real* above;                   ///< (j+1, k)
  const Real* below;                   ///< (j-1, k)
  const Real* back;                    ///< (j, k-1); read if diffusion is implicit
  const Real* front;                   ///< (j, k+1)
  const Real* v_below_front;           ///< v of (j-1, k+1), as it was before the sweep
  Real* tendency;                      ///< (j, k)
  const Real *ahead, *tendency_ahead;  ///< velocity and tendency of rows that come later
  const Real *p, *p_above, *p_front;   ///< (j, k), (j+1, k), (j, k+1), one component
  const Real* p_ahead;                 ///< of a row that comes later
  Real* front_flux;                    ///< of row k-1, then of row k
  std::array<Real*, 3> out;            ///< where u, v and w go; may be `below`
};

/// What flows through one face of the volumes around u, v and w, for some neighbours along x.
template <class Real>
using Fluxes = std::array<WideVector<Real>, 3>;

/// Momentum fluxes through the faces of the volumes around u, v and w of one row, over h:
///
///   F = 1/4 (a1 + a2) (q + q_next) / h - nu (q_next - q) / h^2
///
/// with face values of q and of the advecting velocity a as means of their two neighbours. This
/// divergence form conserves momentum, and kinetic energy where the discrete divergence is zero
/// (Harlow & Welch 1965; Morinishi et al., J. Comput. Phys. 143 (1998) 90, eq. (70)). Convection of
/// u by v and of v by u meet on the same edge with the same product, likewise of the other pairs.
///
/// On stretched y the distances to the points above and below enter diffusion, and the mean of a1,
/// a2 for v's volume weighs its two half cells by their height, so that each volume's own flux
/// balances: momentum and energy are kept as on cubes (Verstappen & Veldman, J. Comput. Phys. 187
/// (2003) 343). u and w take the metric of the cells of plane j, v that of their upper faces.
///
/// With implicit diffusion they are those of convection alone.
template <class Term, class Real>
class RowFluxes {
 public:
  using Vector = WideVector<Real>;

  RowFluxes(const MomentumFactors<Real>& factor, const PlaneMetric<Real>& cell,
            const PlaneMetric<Real>& face, const MomentumRows<Real>& r)
      : factor_(factor), cell_(cell), face_(face), c_(r.component), r_(r) {}

  [[gnu::always_inline]] Fluxes<Real> east(int i) const {
    const Vector u = load_wide(r_.here + i), v = load_wide(r_.here + c_ + i),
                 w = load_wide(r_.here + 2 * c_ + i);
    const Vector u_east = load_wide(r_.here + i + 1), v_east = load_wide(r_.here + c_ + i + 1),
                 w_east = load_wide(r_.here + 2 * c_ + i + 1);
    return {flux(u + u_east, u, u_east), flux(over_v(u, load_wide(r_.above + i)), v, v_east),
            flux(u + load_wide(r_.front + i), w, w_east)};
  }

  [[gnu::always_inline]] Fluxes<Real> front(int i) const {
    const Vector u = load_wide(r_.here + i), v = load_wide(r_.here + c_ + i),
                 w = load_wide(r_.here + 2 * c_ + i);
    const Vector u_front = load_wide(r_.front + i), v_front = load_wide(r_.front + c_ + i),
                 w_front = load_wide(r_.front + 2 * c_ + i);
    return {flux(w + load_wide(r_.here + 2 * c_ + i + 1), u, u_front),
            flux(over_v(w, load_wide(r_.above + 2 * c_ + i)), v, v_front),
            flux(w + w_front, w, w_front)};
  }

  [[gnu::always_inline]] Fluxes<Real> north(int i) const {
    const Vector u = load_wide(r_.here + i), v = load_wide(r_.here + c_ + i),
                 w = load_wide(r_.here + 2 * c_ + i);
    const Vector u_above = load_wide(r_.above + i), v_above = load_wide(r_.above + c_ + i),
                 w_above = load_wide(r_.above + 2 * c_ + i);
    return {flux(v + load_wide(r_.here + c_ + i + 1), u, u_above, cell_.above),
            flux(v + v_above, v, v_above, face_.above),
            flux(v + load_wide(r_.front + c_ + i), w, w_above, cell_.above)};
  }

  [[gnu::always_inline]] Fluxes<Real> south(int i) const {
    const Vector u = load_wide(r_.here + i), v = load_wide(r_.here + c_ + i),
                 w = load_wide(r_.here + 2 * c_ + i);
    const Vector u_below = load_wide(r_.below + i), v_below = load_wide(r_.below + c_ + i),
                 w_below = load_wide(r_.below + 2 * c_ + i);
    return {flux(v_below + load_wide(r_.below + c_ + i + 1), u_below, u, cell_.below),
            flux(v_below + v, v_below, v, face_.below),
            flux(v_below + load_wide(r_.v_below_front + i), w_below, w, cell_.below)};
  }

 private:
  [[gnu::always_inline]] Vector flux(Vector advecting, Vector here, Vector next,
                                     Real closeness = Real(1)) const {
    const auto convection = [&] { return factor_.convection * (advecting * (here + next)); };
    const auto diffusion = [&] {
      return (Term::stretched ? factor_.diffusion * closeness : factor_.diffusion) * (next - here);
    };
    if constexpr (Term::convection && Term::implicit) return convection();
    if constexpr (Term::convection && !Term::implicit) return convection() - diffusion();
    if constexpr (!Term::convection && !Term::implicit) return -diffusion();
    return Vector{};
  }
  /// The advecting velocity over v's volume, twice: weighted by the half cells' heights.
  [[gnu::always_inline]] Vector over_v(Vector here, Vector above) const {
    if constexpr (Term::stretched) return face_.here * here + face_.next * above;
    return here + above;
  }

  const MomentumFactors<Real> factor_;
  const PlaneMetric<Real> cell_, face_;
  const std::size_t c_;
  const MomentumRows<Real> r_;
};

/// Sum over the neighbours of q minus q itself, along y weighted with their closeness: h^2 times
/// the Laplacian.
template <class Term, class Real>
[[gnu::always_inline]] inline WideVector<Real> laplacian(const PlaneMetric<Real>& y,
                                                         const MomentumRows<Real>& r,
                                                         std::size_t at) {
  const WideVector<Real> q = load_wide(r.here + at);
  const WideVector<Real> above = load_wide(r.above + at) - q, below = load_wide(r.below + at) - q;
  const WideVector<Real> level = (load_wide(r.here + at - 1) + load_wide(r.here + at + 1)) +
                                 (load_wide(r.back + at) + load_wide(r.front + at)) - Real(4) * q;
  if constexpr (Term::stretched) return level + y.height * (y.above * above + y.below * below);
  return level + (above + below);
}

/// One row of all three components,
///
///   N  = -[ F_east - F_west + (F_north - F_south) height + F_front - F_back ]
///   q* = q + gamma dt N + zeta dt N_old + push - 2 alpha dt (p_next - p_here) / h
///
/// with the fluxes above; on stretched y the volume around q is 1/height times h high. Each flux
/// through an eastern face serves as the next cell's western one, that through a front face, kept
/// in `front_flux`, as the next row's. With implicit diffusion N is convection alone, and what is
/// computed is the right-hand side for the increment d = q* - q, which needs no wall values of its
/// own:
///
///   d - after dt nu L d = gamma dt N + zeta dt N_old + push - 2 alpha dt grad p + 2 alpha dt nu L
///   q
///
/// `tendency` holds N_old and then N. `ahead`, `tendency_ahead` and `p_ahead`, rows that the sweep
/// comes to next, are asked for on the way. Reads up to a vector more than a row on either side.
template <class Term, class Real>
void predict_row(int nx, const MomentumFactors<Real>& factor, const PlaneMetric<Real>& cell,
                 const PlaneMetric<Real>& face, const std::array<Real, 3>& push,
                 const MomentumRows<Real>& rows) {
  using Vector = WideVector<Real>;
  constexpr int width = wide_width<Real>;
  const MomentumFactors<Real> k = factor;
  const MomentumRows<Real> r = rows;
  const std::size_t component = r.component;
  const RowFluxes<Term, Real> fluxes(factor, cell, face, rows);
  const Real height[3] = {cell.height, face.height, cell.height};
  const std::array<Real, 3> given = push;
  Fluxes<Real> east_before = fluxes.east(-width);
  const auto predict = [&](int i, auto put, auto put_tendency) __attribute__((always_inline)) {
    const Fluxes<Real> east = fluxes.east(i), front = fluxes.front(i), north = fluxes.north(i),
                       south = fluxes.south(i);
    Fluxes<Real> n, result;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = c * component + static_cast<std::size_t>(i);
      const Vector west = moved_up(east_before[c], east[c]), back = load_wide(r.front_flux + at);
      const Vector inwards = south[c] - north[c];
      n[c] =
          (west - east[c]) + (Term::stretched ? height[c] * inwards : inwards) + (back - front[c]);
      if constexpr (Term::implicit)
        result[c] = k.diffusion * laplacian<Term>(c == 1 ? face : cell, r, at);
      else
        result[c] = load_wide(r.here + at);
      result[c] += k.gamma_dt * n[c] + given[c];
      if constexpr (Term::old) result[c] += k.zeta_dt * load_wide(r.tendency + at);
      if constexpr (Term::pressure) {
        const Real* next = (c == 0 ? r.p + 1 : c == 1 ? r.p_above : r.p_front) + i;
        const Real weight = Term::stretched && c == 1 ? k.pressure * height[c] : k.pressure;
        result[c] -= weight * (load_wide(next) - load_wide(r.p + i));
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = c * component + static_cast<std::size_t>(i);
      put(r.front_flux + at, front[c]);
      if constexpr (Term::keep) put_tendency(r.tendency + at, n[c]);
      put(r.out[c] + i, result[c]);
    }
    east_before = east;
  };
  int i = 0;
  for (; i + width <= nx; i += width) {
    if constexpr (Term::pressure) __builtin_prefetch(r.p_ahead + i, 0);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = c * component + static_cast<std::size_t>(i);
      __builtin_prefetch(r.ahead + at, 0);
      if constexpr (!Term::past_caches && (Term::old || Term::keep))
        __builtin_prefetch(r.tendency_ahead + at, 1);
    }
    const auto put = [](Real* to, const Vector& values) { store(to, values); };
    predict(i, put, [&](Real* to, const Vector& values) {
      Term::past_caches ? store_past_caches(to, values) : put(to, values);
    });
  }
  const auto put_rest = [&](Real* to, const Vector& values) { store_first(nx - i, to, values); };
  if (i < nx) predict(i, put_rest, put_rest);
}

/// `front_flux` of one row.
template <class Term, class Real>
void keep_front_flux(int nx, const MomentumFactors<Real>& factor, const PlaneMetric<Real>& cell,
                     const PlaneMetric<Real>& face, const MomentumRows<Real>& rows) {
  const RowFluxes<Term, Real> fluxes(factor, cell, face, rows);
  for (int i = 0; i < nx; i += wide_width<Real>) {
    const Fluxes<Real> front = fluxes.front(i);
    for (std::size_t c = 0; c < 3; ++c) store(rows.front_flux + c * rows.component + i, front[c]);
  }
}

}  // namespace bedload
