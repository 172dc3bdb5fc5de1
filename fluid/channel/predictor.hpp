#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "fluid/channel/momentum.hpp"
#include "fluid/channel/wall_ghosts.hpp"
#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/kernels/past_caches.hpp"
#include "fluid/kernels/tiles.hpp"

namespace bedload {

/// Everything that the predictor of one stage needs beside the fields.
template <class Real>
struct PredictorStage {
  MomentumFactors<Real> factor{};
  std::array<Real, 3> push{};  ///< 2 alpha dt times the driving acceleration
  bool convection = true;      ///< Terms, decided at run time
  bool pressure = false;
  /// Own planes that take the old pressure, if any does; above them it counts as zero.
  int pressure_planes = std::numeric_limits<int>::max();
  bool old_tendency = false;
  bool keep_tendency = false;
  bool implicit = false;
};

/// Plane by plane predictor, some planes at a time where planes are large (Tiles).
///
/// Explicit diffusion: plane j of u* is written over plane j-1, which nothing needs any more once
/// plane j is done: no second velocity array, and the lines written are still in cache. Implicit
/// diffusion: the velocity stays, and the right-hand side for u* - u goes where the caller says.
template <class Real>
class Predictor {
 public:
  Predictor(const Grid& grid, const Decomposition& decomposition, const WallGhosts<Real>& walls,
            Field<Real>& velocity, Field<Real>& tendency, Field<Real>& pressure, Tiles tiles,
            std::size_t stays_in_caches = cached_bytes);

  void begin_stage(const PredictorStage<Real>& stage);

  /// Planes that are predicted at a time, at most.
  int planes_at_once() const { return tiles_.planes; }

  /// u* of planes `first` .. end-1 (all ghosts of velocity valid at the beginning of the sweep),
  /// each into the storage of the plane below, x and z ghosts included. To be called for all planes
  /// in turn, upwards, at most planes_at_once() at a time. After row k of plane j each_row(j, k)
  /// may use it, the rows before it and those of the planes below; the ghost rows, and what a wall
  /// in front makes of the last row, come at the end.
  template <class EachRow>
  void planes(int first, int end, EachRow each_row) {
    const int nz = velocity_.nz();
    // The plane above begins before this one ends.
    const auto overtaken = [&](int j) { return j + 1 < end && tiles_.rows < nz; };
    for (int begin = 0; begin < nz; begin += tiles_.rows)
      for (int j = first; j < end; ++j) {
        if (begin == 0) begin_plane(j, j - first);
        for (int k = begin; k < std::min(begin + tiles_.rows, nz); ++k) {
          const auto out = [&](int c) { return velocity_.row(j - 1, k, c); };
          row(j, k, j - first, front_row(j, k, overtaken(j) ? j + 1 - first : 0),
              {out(0), out(1), out(2)});
          for (int c = 0; c < 3; ++c) walls_.close_row(out(c), c);
          each_row(j, k);
        }
      }
    for (int j = first; j < end; ++j) walls_.close_plane(velocity_, j - 1);
  }

  /// The right-hand side of plane j for u* - u, component c of row k into out(c, k).
  template <class Out>
  void implicit_plane(int j, Out out) {
    begin_plane(j, 0);
    for (int k = 0; k < velocity_.nz(); ++k)
      row(j, k, 0, velocity_.row(j, k + 1), {out(0, k), out(1, k), out(2, k)});
  }

 private:
  /// The loops of momentum.hpp with the terms of this stage.
  struct Loops {
    void (*keep_front_flux)(int nx, const MomentumFactors<Real>&, const PlaneMetric<Real>& cell,
                            const PlaneMetric<Real>& face, const MomentumRows<Real>&);
    void (*predict_row)(int nx, const MomentumFactors<Real>&, const PlaneMetric<Real>& cell,
                        const PlaneMetric<Real>& face, const std::array<Real, 3>& push,
                        const MomentumRows<Real>&);
  };
  static Loops choose(const PredictorStage<Real>& stage, bool pressure, bool stretched,
                      bool past_caches);

  const Loops& loops(int j) const { return j < stage_.pressure_planes ? loops_ : loops_above_; }
  void begin_plane(int j, int place);
  const Real* front_row(int j, int k, int place_above) const;
  void row(int j, int k, int place, const Real* front, const std::array<Real*, 3>& out);

  /// What belongs to one of the planes that are predicted at a time.
  struct Passing {
    AlignedArray<Real> first_below;  ///< first row of the plane below, x ghosts included
    AlignedArray<Real> front_flux;   ///< of the row that is predicted, three components
  };

  const WallGhosts<Real>& walls_;
  Field<Real>&velocity_, &tendency_, &pressure_;
  bool stretched_, tendency_past_caches_;
  std::vector<PlaneMetric<Real>> cells_, faces_;  // of the own planes
  Tiles tiles_;
  std::vector<Passing> passing_;
  PredictorStage<Real> stage_;
  Loops loops_{}, loops_above_{};   ///< of planes with the old pressure, of those above
  AlignedArray<Real> no_pressure_;  ///< one row
};

}  // namespace bedload
