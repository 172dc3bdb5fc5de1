#pragma once

#include "fluid/settings/settings.hpp"

namespace bedload {

/// The mean acceleration that drives the flow along x: none, that of a pressure gradient or of
/// gravity, or what keeps the bulk velocity. In the last case the predictor gives the mean of the
/// step before, and each stage adds what is missing, a uniform shift of u that the projection
/// leaves alone.
class MeanDriving {
 public:
  explicit MeanDriving(const Settings& settings)
      : flow_(settings.flow), constant_(settings.constant_driving() / settings.fluid.density) {
    set(0.0);
  }

  /// As the settings give it, or, where a bulk velocity is kept, what was `found` to keep it in the
  /// last step (also of another run, whose state this one goes on from) [L/T^2].
  void set(double found) {
    switch (flow_.driving) {
      case Driving::none:
        acceleration_ = 0.0;
        return;
      case Driving::pressure_gradient:
      case Driving::gravity:
        acceleration_ = constant_;
        return;
      case Driving::bulk_velocity:
        acceleration_ = found;
        return;
    }
  }

  void begin_step() {
    predicted_ = acceleration_;
    this_step_ = 0.0;
  }
  /// What the predictor gives in this step [L/T^2].
  double predicted() const { return predicted_; }
  /// What u needs everywhere so that its mean, `bulk` before, is the wanted one; the fields can
  /// only take it as rounded to their precision [L/T].
  template <class Real>
  double missing(double bulk) const {
    if (flow_.driving != Driving::bulk_velocity) return 0.0;
    return static_cast<Real>(flow_.bulk_velocity - bulk);
  }
  /// Takes note of a stage of length `stage` in a step of length `step` [T].
  void count(double stage, double step, double shift) {
    this_step_ += (stage * predicted_ + shift) / step;
  }
  void end_step() { set(this_step_); }

  /// Mean of the last step [L/T^2].
  double acceleration() const { return acceleration_; }

 private:
  Settings::Flow flow_;
  double constant_;  ///< of a pressure gradient or of gravity [L/T^2]
  double acceleration_ = 0.0, predicted_ = 0.0, this_step_ = 0.0;
};

}  // namespace bedload
