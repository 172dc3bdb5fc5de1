#include "fluid/immersed_boundary/marker_force.hpp"

#include <array>

#include "fluid/immersed_boundary/immersed_boundary.hpp"

// The markers' force that stands in the equation of implicit diffusion.

namespace bedload {
namespace {

constexpr std::array<std::size_t, 3> components{0, 1, 2};

}  // namespace

template <class Real>
const Field<Real>& ImmersedBoundary<Real>::spread_kept_force(double stage_step, double time_step) {
  const auto share =
      static_cast<Real>(marker_force_share(viscosity_ * time_step / (grid_.h * grid_.h)));
  const auto step = static_cast<Real>(stage_step);
  for (Lists* lists : {&fixed_lists_, &mobile_lists_})
    for (MarkerList<Real>& list : *lists)
      for (std::size_t m = 0; m < list.kept_force.size(); ++m) {
        list.kept_force[m] *= share;
        list.increment[m] = step * list.kept_force[m];
      }
  spread_all(scratch_);
  halo_.collect(scratch_);
  kept_force_gain_ = marker_force_gain / time_step;
  return scratch_;
}

template <class Real>
void ImmersedBoundary<Real>::clear_kept_force() {
  scratch_.fill(Real{});
}

/// f += gain increment/dt for all markers.
template <class Real>
void ImmersedBoundary<Real>::keep_increments() {
  const auto gain = static_cast<Real>(kept_force_gain_);
  for (Lists* lists : {&fixed_lists_, &mobile_lists_})
    for (MarkerList<Real>& list : *lists)
      for (std::size_t m = 0; m < list.kept_force.size(); ++m)
        list.kept_force[m] += gain * list.increment[m];
}

/// All ranks near a sphere come to know the force of all its markers, any of which may be theirs in
/// the next stage.
template <class Real>
void ImmersedBoundary<Real>::share_kept_forces() {
  share_by_marker(&Mobile::kept_forces, &MarkerList<Real>::kept_force);
}

/// For the markers of the mobile spheres as they are now; those of a sphere that is new have none.
template <class Real>
void ImmersedBoundary<Real>::use_kept_forces() {
  if (!keeps_force_) return;
  for (const std::size_t c : components) {
    MarkerList<Real>& list = mobile_lists_[c];
    list.kept_force.resize(static_cast<std::size_t>(list.size()));
    take_by_marker(list, c, &Mobile::kept_forces, list.kept_force, Real{});
  }
}

template const Field<float>& ImmersedBoundary<float>::spread_kept_force(double, double);
template void ImmersedBoundary<float>::clear_kept_force();
template void ImmersedBoundary<float>::keep_increments();
template void ImmersedBoundary<float>::share_kept_forces();
template void ImmersedBoundary<float>::use_kept_forces();
template const Field<double>& ImmersedBoundary<double>::spread_kept_force(double, double);
template void ImmersedBoundary<double>::clear_kept_force();
template void ImmersedBoundary<double>::keep_increments();
template void ImmersedBoundary<double>::share_kept_forces();
template void ImmersedBoundary<double>::use_kept_forces();

}  // namespace bedload
