#pragma once

#include <array>
#include <vector>

#include "fluid/decomposition.hpp"
#include "fluid/field.hpp"
#include "fluid/momentum.hpp"
#include "fluid/sweep.hpp"
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
  bool implicit = false;
};

/// Plane by plane predictor.
///
/// Explicit diffusion: plane j of u* is written over the plane that the sweep comes from (j-1 on
/// the way up), which nothing needs any more once plane j is done: no second velocity array, and
/// the lines written are still in cache. Implicit diffusion: the velocity stays, and the right-hand
/// side for u* - u goes where the caller says.
template <class Real>
class Predictor {
 public:
  Predictor(const Grid& grid, const Decomposition& slabs, const WallGhosts<Real>& walls,
            Field<Real>& velocity, Field<Real>& tendency, Field<Real>& pressure);

  void begin_stage(const PredictorStage<Real>& stage);

  /// u* of plane j (all ghosts of velocity valid at the beginning of the sweep) into the storage of
  /// plane j-1 on the way up, j+1 on the way down, x and z ghosts included. To be called for all
  /// planes in turn. After each row, each_row(k) may use it; the ghost rows, and what a wall in
  /// front makes of the last row, come at the end.
  template <class EachRow>
  void plane(int j, Sweep direction, EachRow each_row) {
    const int nz = velocity_.nz(), to = j - step_of(direction);
    keep_what_is_overwritten(to, direction);
    for (int n = 0; n < nz; ++n) {
      const int k = plane_of(direction, n, nz);
      row(j, k, direction,
          {velocity_.row(to, k, 0), velocity_.row(to, k, 1), velocity_.row(to, k, 2)});
      for (int c = 0; c < 3; ++c) walls_.close_row(velocity_.row(to, k, c), c);
      each_row(k);
    }
    walls_.close_plane(velocity_, to);
  }

  /// The right-hand side of plane j for u* - u, component c of row k into out(c, k).
  template <class Out>
  void implicit_plane(int j, Out out) {
    for (int k = 0; k < velocity_.nz(); ++k)
      row(j, k, Sweep::up, {out(0, k), out(1, k), out(2, k)});
  }

 private:
  using Predict = void (*)(int nx, const MomentumFactors<Real>&, const PlaneMetric<Real>& cell,
                           const PlaneMetric<Real>& face, const Real (&push)[3],
                           const MomentumRows<Real>&);
  static Predict choose(const PredictorStage<Real>& stage, bool stretched);

  void keep_what_is_overwritten(int plane, Sweep direction);
  void row(int j, int k, Sweep direction, const std::array<Real*, 3>& out);

  const WallGhosts<Real>& walls_;
  Field<Real>&velocity_, &tendency_, &pressure_;
  bool stretched_;
  std::vector<PlaneMetric<Real>> cells_, faces_;  // of the own planes
  std::vector<Real> saved_;
  PredictorStage<Real> stage_;
  Predict predict_ = nullptr;
};

}  // namespace bedload
