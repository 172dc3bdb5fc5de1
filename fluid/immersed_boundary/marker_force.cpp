#include "fluid/immersed_boundary/marker_force.hpp"

#include "fluid/immersed_boundary/immersed_boundary.hpp"

// The markers' force that stands in the equation of implicit diffusion.

namespace bedload {

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

template const Field<float>& ImmersedBoundary<float>::spread_kept_force(double, double);
template void ImmersedBoundary<float>::clear_kept_force();
template void ImmersedBoundary<float>::keep_increments();
template const Field<double>& ImmersedBoundary<double>::spread_kept_force(double, double);
template void ImmersedBoundary<double>::clear_kept_force();
template void ImmersedBoundary<double>::keep_increments();

}  // namespace bedload
