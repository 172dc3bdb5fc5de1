#pragma once

#include <limits>
#include <span>
#include <vector>

#include "fluid/channel/phase_clock.hpp"
#include "fluid/channel/wall_ghosts.hpp"
#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/kernels/compensated_sum.hpp"
#include "fluid/kernels/tiles.hpp"
#include "fluid/poisson/poisson.hpp"

namespace bedload {

/// Makes u* free of divergence, plane by plane:
///
///   (h^2 Laplacian) phi = h^2 div u* / step,    u = u* - step grad phi + shift e_x.
///
/// Upwards: begin(), then the planes of u* are taken and eliminated, some at a time where planes
/// are large (Tiles); couple(); downwards: correct(), which takes them likewise.
template <class Real>
class PressureProjection {
 public:
  enum class PressureUse { none, add, replace };
  struct Correction {
    double step;                               ///< length of the stage [T]
    double shift = 0.0;                        ///< added to u [L/T]
    bool measure = false;                      ///< whether sum and largest speed are taken
    int moved = 0;                             ///< planes that u* lies below its place
    PressureUse pressure = PressureUse::none;  ///< what becomes of phi
    /// In own planes from this one on that is `pressure_above` instead.
    int pressure_planes = std::numeric_limits<int>::max();
    PressureUse pressure_above = PressureUse::none;
    double pressure_share = 1.0;  ///< s of p + s phi
  };
  /// What the elimination takes of one plane: div u*, row by row, and the sum of u*.
  struct Outflow {
    int j, at;  ///< plane, and the one in whose storage its u* is
    double thickness;
    Real in_plane, upwards;  ///< areas over h^2, times h/(stage's length)
    double sum = 0.0;
  };

  /// All must outlive this object. Rows of up to `planes_ahead` planes one after the other may be
  /// taken before these are eliminated.
  PressureProjection(const Grid& grid, const Decomposition& decomposition,
                     const WallGhosts<Real>& walls, Field<Real>& velocity, Field<Real>& pressure,
                     PhaseClock& clock, Tiles tiles, int planes_ahead);

  void begin() { sum_ = {}; }
  Outflow outflow(int j, int at, double step) const;
  void take_row(Outflow& flow, int k);
  void eliminate_planes(std::span<const Outflow> flows);
  void eliminate_planes(int first, int end, double step);
  void couple() { poisson_.couple(); }
  void correct(const Correction& correction);

  /// Of u* once all planes are eliminated, of u once they are corrected: sum over this rank's cells
  /// (streamwise_sum) and largest |u|+|v|+|w| [L/T].
  double local_sum() const { return sum_.value(); }
  double local_fastest() const { return fastest_; }

 private:
  void end_outflow(const Outflow& flow);
  void correct_planes(int first, int end, const Correction& correction);
  void correct_row(int j, int k, const Correction& correction);
  void update_pressure(int j, int first_row, int end_row, const Correction& correction);

  const Grid& grid_;
  const Decomposition& decomposition_;
  const WallGhosts<Real>& walls_;
  Field<Real>&velocity_, &pressure_;
  PhaseClock& clock_;
  Tiles tiles_;
  PoissonSolver<Real> poisson_;
  std::vector<Real> zeros_;
  CompensatedSum sum_;  ///< so that the momentum's budget closes on any number of cells
  double fastest_ = 0.0;
};

}  // namespace bedload
