#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "fluid/field.hpp"
#include "fluid/momentum.hpp"
#include "fluid/wall_ghosts.hpp"

namespace bedload {

/// Everything that the predictor of one stage needs beside the fields.
template <class Real>
struct PredictorStage {
  MomentumFactors<Real> factor{};
  Real push[3] = {};       ///< 2 alpha dt times the driving acceleration
  bool convection = true;  ///< Terms, decided at run time
  bool pressure = false;
  bool old_tendency = false;
  bool keep_tendency = false;
};

/// Plane by plane predictor. Plane j is written over plane j-1, which nothing needs any more once
/// plane j is done: no second velocity array, and the lines written are still in cache.
template <class Real>
class Predictor {
 public:
  Predictor(const WallGhosts<Real>& walls, Field<Real>& velocity, Field<Real>& tendency,
            Field<Real>& pressure)
      : walls_(walls),
        velocity_(velocity),
        tendency_(tendency),
        pressure_(pressure),
        saved_(static_cast<std::size_t>(velocity.nx()) + 2) {}

  void begin_stage(const PredictorStage<Real>& stage) {
    stage_ = stage;
    predict_ = choose(stage);
  }

  /// u* of plane j (all ghosts of velocity valid at the beginning of the sweep) into the storage of
  /// plane j-1, x and z ghosts included. To be called for j = 0, 1, .., planes-1 in this order.
  void plane(int j) {
    // The last row's w needs v of the plane below in row 0, which is overwritten first.
    const Real* v = velocity_.row(j - 1, 0, 1);
    std::copy_n(v - 1, saved_.size(), saved_.begin());
    (this->*predict_)(j);
  }

 private:
  using Predict = void (Predictor::*)(int);

  template <class Term>
  void predict(int j) {
    const int nx = velocity_.nx(), nz = velocity_.nz();
    for (int k = 0; k < nz; ++k) {
      const bool wraps = k == nz - 1 && velocity_.row(j - 1, nz, 1) == velocity_.row(j - 1, 0, 1);
      predict_velocity<Term>(
          nx, stage_.factor, stage_.push,
          {.component = velocity_.component_stride(),
           .here = velocity_.row(j, k),
           .above = velocity_.row(j + 1, k),
           .below = velocity_.row(j - 1, k),
           .back = velocity_.row(j, k - 1),
           .front = velocity_.row(j, k + 1),
           .above_back = velocity_.row(j + 1, k - 1),
           .v_below_front = wraps ? saved_.data() + 1 : velocity_.row(j - 1, k + 1, 1),
           .tendency = tendency_.row(j, k),
           .ahead = velocity_.row(j + 1, k + 1),
           .tendency_ahead = tendency_.row(j, k + 1),
           .p = pressure_.row(j, k),
           .p_above = pressure_.row(j + 1, k),
           .p_front = pressure_.row(j, k + 1)});
      for (int c = 0; c < 3; ++c) walls_.close_row(velocity_.row(j - 1, k, c), c);
    }
    walls_.close_plane(velocity_, j - 1);
  }

  static Predict choose(const PredictorStage<Real>& s) {
    return s.convection ? choose_pressure<true>(s) : choose_pressure<false>(s);
  }
  template <bool convection>
  static Predict choose_pressure(const PredictorStage<Real>& s) {
    return s.pressure ? choose_old<convection, true>(s) : choose_old<convection, false>(s);
  }
  template <bool convection, bool pressure>
  static Predict choose_old(const PredictorStage<Real>& s) {
    if (!s.old_tendency) return &Predictor::predict<Terms<convection, pressure, false, true>>;
    if (s.keep_tendency) return &Predictor::predict<Terms<convection, pressure, true, true>>;
    return &Predictor::predict<Terms<convection, pressure, true, false>>;
  }

  const WallGhosts<Real>& walls_;
  Field<Real>&velocity_, &tendency_, &pressure_;
  std::vector<Real> saved_;
  PredictorStage<Real> stage_;
  Predict predict_ = nullptr;
};

}  // namespace bedload
