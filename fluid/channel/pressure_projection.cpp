#include "fluid/channel/pressure_projection.hpp"

#include <algorithm>

#include "fluid/channel/diagnostics.hpp"
#include "fluid/channel/projection.hpp"
#include "fluid/kernels/prefetch.hpp"

namespace bedload {

template <class Real>
PressureProjection<Real>::PressureProjection(const Grid& grid, const Decomposition& decomposition,
                                             const WallGhosts<Real>& walls, Field<Real>& velocity,
                                             Field<Real>& pressure, PhaseClock& clock,
                                             int planes_at_once)
    : grid_(grid),
      decomposition_(decomposition),
      walls_(walls),
      velocity_(velocity),
      pressure_(pressure),
      clock_(clock),
      poisson_(grid, decomposition, pressure_component, planes_at_once),
      zeros_(static_cast<std::size_t>(grid.cells[0]), Real(0)) {}

/// Of plane j, whose u* stands in the storage of plane `at`.
template <class Real>
typename PressureProjection<Real>::Outflow PressureProjection<Real>::outflow(int j, int at,
                                                                             double step) const {
  const double thickness = grid_.thickness(decomposition_.first() + j);
  return {.j = j,
          .at = at,
          .thickness = thickness,
          .in_plane = static_cast<Real>(thickness * grid_.h / step),
          .upwards = static_cast<Real>(grid_.h / step)};
}

/// Puts h/(step) (div u*) h of row k, times the plane's height over h, into the Poisson solver's
/// plane and adds up u*. What the block below lets in is added by couple(), what the block behind
/// lets in comes with the sweep.
template <class Real>
void PressureProjection<Real>::take_row(Outflow& flow, int k) {
  const int nx = grid_.cells[0], at = flow.at;
  const Real* v_below = flow.j == 0 ? zeros_.data() : velocity_.row(at - 1, k, 1);
  const Real* w_back =
      k == 0 && poisson_.gives_to_front() ? zeros_.data() : velocity_.row(at, k - 1, 2);
  divergence_row(nx, flow.in_plane, flow.upwards, velocity_.row(at, k, 0), velocity_.row(at, k, 1),
                 v_below, velocity_.row(at, k, 2), w_back, poisson_.rhs_row(flow.j, k));
  flow.sum += row_sum(nx, velocity_.row(at, k, 0));
}

/// Eliminates a plane, all of whose rows have been taken.
template <class Real>
void PressureProjection<Real>::eliminate_plane(const Outflow& flow) {
  const int nx = grid_.cells[0], nz = decomposition_.rows();
  sum_ += flow.sum * flow.thickness;
  if (poisson_.gives_to_front()) {
    const Real* w = velocity_.row(flow.at, nz - 1, 2);
    Real* given = poisson_.rhs_row(flow.j, nz);
    for (int i = 0; i < nx; ++i) given[i] = -flow.in_plane * w[i];
  }
  if (!decomposition_.at_upper_wall() && flow.j == decomposition_.planes() - 1)
    for (int k = 0; k < nz; ++k) {
      const Real* v = velocity_.row(flow.at, k, 1);
      Real* excess = poisson_.excess_row(k);
      const Real over_gap =
          flow.upwards * static_cast<Real>(grid_.gap(decomposition_.first() + flow.j));
      for (int i = 0; i < nx; ++i) excess[i] = over_gap * v[i];
    }
  clock_.lap(FlowPhase::divergence);
  poisson_.eliminate(flow.j);
  clock_.lap(FlowPhase::elimination);
}

/// The same for a plane whose u* is whole, in its place.
template <class Real>
void PressureProjection<Real>::eliminate_plane(int j, double step) {
  Outflow flow = outflow(j, j, step);
  for (int k = 0; k < decomposition_.rows(); ++k) take_row(flow, k);
  eliminate_plane(flow);
}

/// u = u* - step grad phi + shift; where the predictor moved the planes, each one back into its
/// place.
template <class Real>
void PressureProjection<Real>::correct(const Correction& correction) {
  sum_ = fastest_ = 0.0;
  for (int j = decomposition_.planes() - 1; j >= 0; --j) {
    substitute(j, correction);
    clock_.lap(FlowPhase::substitution);
    correct_plane(j, correction);
    clock_.lap(FlowPhase::correction);
  }
  velocity_.relabel(-correction.moved);
}

/// What is still missing of phi in plane j and in the one above, which the correction of plane j
/// needs.
template <class Real>
void PressureProjection<Real>::substitute(int j, const Correction& correction) {
  if (j == decomposition_.planes() - 1 && !decomposition_.at_upper_wall()) {
    poisson_.substitute(j + 1);
    update_pressure(j + 1, correction);
  }
  poisson_.substitute(j);
}

/// One plane of it, with the plane's share of what the last stage measures.
template <class Real>
void PressureProjection<Real>::correct_plane(int j, const Correction& correction) {
  const int nx = grid_.cells[0], nz = decomposition_.rows(), global = decomposition_.first() + j;
  const bool under_wall = decomposition_.at_upper_wall() && j == decomposition_.planes() - 1;
  const Real factor = static_cast<Real>(correction.step / grid_.h);
  const Real factor_y = static_cast<Real>(correction.step / grid_.h / grid_.gap(global));
  const Real shift = static_cast<Real>(correction.shift);
  const Real stretch = static_cast<Real>(stretch_at(grid_, global));
  double sum = 0.0;
  Real fastest = 0;
  for (int k = 0; k < nz; ++k) {
    const Real* phi = poisson_.solution_row(j, k);
    Real* to = velocity_.row(j + correction.moved, k);
    if (k + 1 < nz) ask_for(velocity_.row_block(j, k + 1), velocity_.row_size());
    correct_row(nx, factor, factor_y, shift, velocity_.component_stride(), velocity_.row(j, k), to,
                phi, under_wall ? phi : poisson_.solution_row(j + 1, k),
                poisson_.solution_row(j, k + 1));
    for (int c = 0; c < 3; ++c)
      walls_.close_row(to + static_cast<std::size_t>(c) * velocity_.component_stride(), c);
    if (!correction.measure) continue;
    sum += row_sum(nx, to);
    fastest = std::max(fastest, largest_speed(nx, stretch, velocity_.component_stride(), to));
  }
  walls_.close_plane(velocity_, j + correction.moved);
  sum_ += sum * grid_.thickness(global);
  fastest_ = std::max(fastest_, static_cast<double>(fastest));
  update_pressure(j, correction);
}

/// p + s phi where the predictor had the old pressure gradient (s < 1 with spheres: the whole would
/// make them oscillate by their added mass, immersed_boundary/README.md), phi itself where it had
/// none (the projection then yields the same velocity, and phi of the last stage is the pressure).
template <class Real>
void PressureProjection<Real>::update_pressure(int j, const Correction& correction) {
  if (correction.pressure == PressureUse::none) return;
  const int nx = grid_.cells[0];
  const Real share = static_cast<Real>(correction.pressure_share);
  for (int k = 0; k < decomposition_.rows() + (poisson_.gives_to_front() ? 1 : 0); ++k) {
    const Real* phi = poisson_.solution_row(j, k);
    Real* p = pressure_.row(j, k);
    if (correction.pressure == PressureUse::replace)
      for (int i = 0; i < nx; ++i) p[i] = phi[i];
    else
      for (int i = 0; i < nx; ++i) p[i] += share * phi[i];
  }
  walls_.close_scalar(pressure_, j);
}

template class PressureProjection<float>;
template class PressureProjection<double>;

}  // namespace bedload
