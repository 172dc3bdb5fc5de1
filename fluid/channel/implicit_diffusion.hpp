#pragma once

#include <vector>

#include "fluid/channel/phase_clock.hpp"
#include "fluid/channel/predictor.hpp"
#include "fluid/channel/wall_ghosts.hpp"
#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/poisson/poisson.hpp"

namespace bedload {

/// The predictor of a stage whose diffusion is implicit: one Helmholtz equation for the increment d
/// of each component (momentum.hpp), solved as
///
///   d - after dt nu L d = rhs    as    (h^2 L - s) d = -s rhs,   s = h^2 / (after dt nu),
///
/// and u* = u + d.
template <class Real>
class ImplicitDiffusion {
 public:
  /// Does nothing unless it is `on`. All must outlive this object.
  ImplicitDiffusion(bool on, double viscosity, const Grid& grid, const Decomposition& decomposition,
                    const WallGhosts<Real>& walls);
  bool on() const { return !solvers_.empty(); }

  /// What acts beside the predictor's terms: change of velocity in the stage, zero above `planes`.
  struct Kick {
    const Field<Real>* change = nullptr;
    int planes = 0;
  };

  /// u* of one stage over u, with the stage's `after` times dt [T]; `predictor` has begun the
  /// stage.
  void solve(Predictor<Real>& predictor, Field<Real>& velocity, double after_dt, const Kick& kick,
             PhaseClock& clock);

 private:
  void eliminate_plane(Predictor<Real>& predictor, int j, double shift, const Kick& kick,
                       PhaseClock& clock);
  void add_increment(Field<Real>& velocity, int j);

  double viscosity_;
  const Grid& grid_;
  const Decomposition& decomposition_;
  const WallGhosts<Real>& walls_;
  std::vector<PoissonSolver<Real>> solvers_;  ///< of u, v, w
};

}  // namespace bedload
