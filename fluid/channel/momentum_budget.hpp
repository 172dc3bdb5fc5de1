#pragma once

#include "fluid/channel/runge_kutta.hpp"

namespace bedload {

/// What one step adds to the streamwise sum of the velocity (streamwise_sum), in that sum's unit
/// [L/T]:
///
///   residual = sum_end - sum_begin - driving - (walls, fringe, spheres),
///
/// zero to round-off, for the scheme conserves momentum.
class MomentumBudget {
 public:
  void begin_step(double sum) {
    *this = MomentumBudget();
    begin_ = sum;
  }
  /// By driving, all ranks.
  void add_driving(double gained) { driving_ += gained; }
  /// By fringe, spheres and implicit diffusion, this rank's share.
  void add_local(double gained) { local_ += gained; }
  /// By wall stress, this rank's share: `walls` is its rate at the begin of the stage, and enters
  /// as the tendency does.
  void add_walls(const Stage& stage, double dt, double walls, bool implicit) {
    local_ += implicit ? dt * stage.before * walls
                       : dt * (stage.gamma * walls + stage.zeta * walls_before_);
    walls_before_ = walls;
  }
  double local() const { return local_; }
  /// `local` of all ranks together.
  double residual(double sum_end, double local) const {
    return sum_end - begin_ - driving_ - local;
  }

 private:
  double begin_ = 0.0, driving_ = 0.0, local_ = 0.0;
  double walls_before_ = 0.0;  ///< at the begin of the stage before
};

}  // namespace bedload
