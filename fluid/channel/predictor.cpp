#include "fluid/channel/predictor.hpp"

#include <algorithm>
#include <cstddef>

namespace bedload {
namespace {

template <class Real>
PlaneMetric<Real> cell_metric(const Grid& grid, int j) {
  const double height = 1.0 / grid.thickness(j);
  return {.height = static_cast<Real>(height),
          .above = static_cast<Real>(1.0 / grid.gap(j)),
          .below = static_cast<Real>(1.0 / grid.gap(j - 1))};
}

template <class Real>
PlaneMetric<Real> face_metric(const Grid& grid, int j) {
  const double height = 1.0 / grid.gap(j);
  return {.height = static_cast<Real>(height),
          .above = static_cast<Real>(1.0 / grid.thickness(j + 1)),
          .below = static_cast<Real>(1.0 / grid.thickness(j)),
          .here = static_cast<Real>(height * grid.thickness(j)),
          .next = static_cast<Real>(height * grid.thickness(j + 1))};
}

}  // namespace

template <class Real>
Predictor<Real>::Predictor(const Grid& grid, const Decomposition& decomposition,
                           const WallGhosts<Real>& walls, Field<Real>& velocity,
                           Field<Real>& tendency, Field<Real>& pressure, Tiles tiles,
                           std::size_t stays_in_caches)
    : walls_(walls),
      velocity_(velocity),
      tendency_(tendency),
      pressure_(pressure),
      stretched_(grid.stretched()),
      tendency_past_caches_(tendency.bytes() > stays_in_caches),
      tiles_(tiles),
      no_pressure_(pressure.row_size() + wide_width<Real>) {
  for (int n = 0; n < tiles_.planes; ++n)
    passing_.push_back({AlignedArray<Real>(velocity.row_size() + wide_width<Real>),
                        AlignedArray<Real>(velocity.row_size() + wide_width<Real>)});
  for (int j = 0; j < decomposition.planes(); ++j) {
    cells_.push_back(cell_metric<Real>(grid, decomposition.first() + j));
    faces_.push_back(face_metric<Real>(grid, decomposition.first() + j));
  }
}

template <class Real>
void Predictor<Real>::begin_stage(const PredictorStage<Real>& stage) {
  stage_ = stage;
  loops_ = choose(stage, stage.pressure, stretched_, tendency_past_caches_);
  loops_above_ = choose(stage, false, stretched_, tendency_past_caches_);
}

/// Keeps what the last row needs and the first one overwrites where z wraps: row 0 of the plane
/// below, whose v goes into w of row nz-1, and all of it into row nz-1 of that plane.
template <class Real>
void Predictor<Real>::begin_plane(int j, int place) {
  Passing& passing = passing_[static_cast<std::size_t>(place)];
  std::copy_n(velocity_.row_block(j - 1, 0), velocity_.row_size(), passing.first_below.data());
  const auto plane = static_cast<std::size_t>(j);
  loops(j).keep_front_flux(velocity_.nx(), stage_.factor, cells_[plane], faces_[plane],
                           {.component = velocity_.component_stride(),
                            .here = velocity_.row(j, -1),
                            .above = velocity_.row(j + 1, -1),
                            .front = velocity_.row(j, 0),
                            .front_flux = passing.front_flux.data()});
}

/// Row k+1 of plane j as it was before the sweep; `place_above` is the place of the plane above if
/// that has begun, else 0.
template <class Real>
const Real* Predictor<Real>::front_row(int j, int k, int place_above) const {
  const Real* front = velocity_.row(j, k + 1);
  const bool wraps = k > 0 && front == velocity_.row(j, 0);
  return wraps && place_above > 0
             ? passing_[static_cast<std::size_t>(place_above)].first_below.data() + 1
             : front;
}

template <class Real>
void Predictor<Real>::row(int j, int k, int place, const Real* front,
                          const std::array<Real*, 3>& out) {
  const int nx = velocity_.nx(), nz = velocity_.nz();
  const auto plane = static_cast<std::size_t>(j);
  Passing& passing = passing_[static_cast<std::size_t>(place)];
  const Real* v_below_front = velocity_.row(j - 1, k + 1, 1);
  const bool over_below = out[0] == velocity_.row(j - 1, k);
  if (over_below && k == nz - 1 && v_below_front == velocity_.row(j - 1, 0, 1))
    v_below_front = passing.first_below.data() + 1 + velocity_.component_stride();
  loops(j).predict_row(
      nx, stage_.factor, cells_[plane], faces_[plane], stage_.push,
      {.component = velocity_.component_stride(),
       .here = velocity_.row(j, k),
       .above = velocity_.row(j + 1, k),
       .below = velocity_.row(j - 1, k),
       .back = velocity_.row(j, k - 1),
       .front = front,
       .v_below_front = v_below_front,
       .tendency = tendency_.row(j, k),
       .ahead = velocity_.row(j + 1, k + 1),
       .tendency_ahead = tendency_.row(j, k + 1),
       .p = pressure_.row(j, k),
       .p_above = j + 1 == stage_.pressure_planes ? no_pressure_.data() : pressure_.row(j + 1, k),
       .p_front = pressure_.row(j, k + 1),
       .p_ahead = pressure_.row(j + 1, k + 1),
       .front_flux = passing.front_flux.data(),
       .out = out});
}

namespace {

/// Turns run-time switches into template arguments, one after the other.
template <class Use>
auto with(bool on, Use use) {
  return on ? use(std::true_type{}) : use(std::false_type{});
}

}  // namespace

template <class Real>
typename Predictor<Real>::Loops Predictor<Real>::choose(const PredictorStage<Real>& s,
                                                        bool has_pressure, bool is_stretched,
                                                        bool past_caches) {
  const auto loops = []<class Term>(Term) {
    return Loops{&bedload::keep_front_flux<Term, Real>, &bedload::predict_row<Term, Real>};
  };
  return with(s.convection, [&](auto convection) {
    return with(is_stretched, [&](auto stretched) {
      const auto rest = [&](auto pressure, auto implicit) {
        constexpr bool c = convection, p = pressure, y = stretched, i = implicit;
        if (!s.old_tendency)
          return with(past_caches, [&](auto past) {
            constexpr bool beyond = past;
            return loops(Terms<c, p, false, true, y, i, beyond>{});
          });
        if (s.keep_tendency) return loops(Terms<c, p, true, true, y, i>{});
        return loops(Terms<c, p, true, false, y, i>{});
      };
      if (s.implicit) return rest(std::true_type{}, std::true_type{});
      return has_pressure ? rest(std::true_type{}, std::false_type{})
                          : rest(std::false_type{}, std::false_type{});
    });
  });
}

template class Predictor<float>;
template class Predictor<double>;

}  // namespace bedload
