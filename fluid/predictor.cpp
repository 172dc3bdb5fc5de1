#include "fluid/predictor.hpp"

#include <algorithm>
#include <cstddef>

namespace bedload {
namespace {

template <class Real>
PlaneMetric<Real> cell_metric(const Grid& grid, int j) {
  const double height = 1.0 / grid.thickness(j);
  return {.height = static_cast<Real>(height),
          .above = static_cast<Real>(height / grid.gap(j)),
          .below = static_cast<Real>(height / grid.gap(j - 1))};
}

template <class Real>
PlaneMetric<Real> face_metric(const Grid& grid, int j) {
  const double height = 1.0 / grid.gap(j);
  return {.height = static_cast<Real>(height),
          .above = static_cast<Real>(height / grid.thickness(j + 1)),
          .below = static_cast<Real>(height / grid.thickness(j)),
          .here = static_cast<Real>(height * grid.thickness(j)),
          .next = static_cast<Real>(height * grid.thickness(j + 1))};
}

}  // namespace

template <class Real>
Predictor<Real>::Predictor(const Grid& grid, const Decomposition& slabs,
                           const WallGhosts<Real>& walls, Field<Real>& velocity,
                           Field<Real>& tendency, Field<Real>& pressure)
    : walls_(walls),
      velocity_(velocity),
      tendency_(tendency),
      pressure_(pressure),
      stretched_(grid.stretched()),
      saved_(static_cast<std::size_t>(velocity.nx()) + 2) {
  for (int j = 0; j < slabs.planes(); ++j) {
    cells_.push_back(cell_metric<Real>(grid, slabs.first() + j));
    faces_.push_back(face_metric<Real>(grid, slabs.first() + j));
  }
}

template <class Real>
void Predictor<Real>::begin_stage(const PredictorStage<Real>& stage) {
  stage_ = stage;
  predict_ = choose(stage, stretched_);
}

/// Where z wraps, the last row that is predicted needs what the first one overwrites: on the way up
/// the w of row nz-1 needs v below row 0, on the way down the v of row 0 needs w above row nz-1.
template <class Real>
void Predictor<Real>::keep_what_is_overwritten(int plane, Sweep direction) {
  const Real* needed = direction == Sweep::up ? velocity_.row(plane, 0, 1)
                                              : velocity_.row(plane, velocity_.nz() - 1, 2);
  std::copy_n(needed - 1, saved_.size(), saved_.begin());
}

template <class Real>
void Predictor<Real>::row(int j, int k, Sweep direction, const std::array<Real*, 3>& out) {
  const int nx = velocity_.nx(), nz = velocity_.nz(), next = step_of(direction);
  const auto plane = static_cast<std::size_t>(j);
  const Real* v_below_front = velocity_.row(j - 1, k + 1, 1);
  const Real* w_above_back = velocity_.row(j + 1, k - 1, 2);
  const bool over_below = out[0] == velocity_.row(j - 1, k);
  const bool over_above = out[0] == velocity_.row(j + 1, k);
  if (over_below && k == nz - 1 && v_below_front == velocity_.row(j - 1, 0, 1))
    v_below_front = saved_.data() + 1;
  if (over_above && k == 0 && w_above_back == velocity_.row(j + 1, nz - 1, 2))
    w_above_back = saved_.data() + 1;
  predict_(nx, stage_.factor, cells_[plane], faces_[plane], stage_.push,
           {.component = velocity_.component_stride(),
            .here = velocity_.row(j, k),
            .above = velocity_.row(j + 1, k),
            .below = velocity_.row(j - 1, k),
            .back = velocity_.row(j, k - 1),
            .front = velocity_.row(j, k + 1),
            .w_above_back = w_above_back,
            .v_below_front = v_below_front,
            .tendency = tendency_.row(j, k),
            .ahead = velocity_.row(j + next, k + next),
            .tendency_ahead = tendency_.row(j, k + next),
            .p = pressure_.row(j, k),
            .p_above = pressure_.row(j + 1, k),
            .p_front = pressure_.row(j, k + 1),
            .out = {out[0], out[1], out[2]}});
}

namespace {

/// Turns run-time switches into template arguments, one after the other.
template <class Use>
auto with(bool on, Use use) {
  return on ? use(std::true_type{}) : use(std::false_type{});
}

}  // namespace

template <class Real>
typename Predictor<Real>::Predict Predictor<Real>::choose(const PredictorStage<Real>& s,
                                                          bool is_stretched) {
  return with(s.convection, [&](auto convection) {
    return with(is_stretched, [&](auto stretched) {
      const auto rest = [&](auto pressure, auto implicit) -> Predict {
        constexpr bool c = convection, p = pressure, y = stretched, i = implicit;
        if (!s.old_tendency) return &predict_velocity<Terms<c, p, false, true, y, i>, Real>;
        if (s.keep_tendency) return &predict_velocity<Terms<c, p, true, true, y, i>, Real>;
        return &predict_velocity<Terms<c, p, true, false, y, i>, Real>;
      };
      if (s.implicit) return rest(std::true_type{}, std::true_type{});
      return s.pressure ? rest(std::true_type{}, std::false_type{})
                        : rest(std::false_type{}, std::false_type{});
    });
  });
}

template class Predictor<float>;
template class Predictor<double>;

}  // namespace bedload
