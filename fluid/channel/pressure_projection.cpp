#include "fluid/channel/pressure_projection.hpp"

#include <algorithm>

#include "fluid/channel/diagnostics.hpp"
#include "fluid/channel/projection.hpp"
#include "fluid/kernels/prefetch.hpp"

namespace bedload {

template <class Real>
PressureProjection<Real>::PressureProjection(const Grid& grid, const Decomposition& decomposition,
                                             const WallGhosts<Real>& walls, Field<Real>& velocity,
                                             Field<Real>& pressure, PhaseClock& clock, Tiles tiles,
                                             int planes_ahead)
    : grid_(grid),
      decomposition_(decomposition),
      walls_(walls),
      velocity_(velocity),
      pressure_(pressure),
      clock_(clock),
      tiles_(tiles),
      poisson_(grid, decomposition, pressure_component, std::max(tiles.planes, planes_ahead)),
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

/// What comes when all rows of a plane have been taken.
template <class Real>
void PressureProjection<Real>::end_outflow(const Outflow& flow) {
  const int nx = grid_.cells[0], nz = decomposition_.rows();
  sum_ += flow.sum * flow.thickness;
  if (poisson_.gives_to_front()) {
    const Real* w = velocity_.row(flow.at, nz - 1, 2);
    Real* given = poisson_.rhs_row(flow.j, nz);
    for (int i = 0; i < nx; ++i) given[i] = -flow.in_plane * w[i];
  }
  if (decomposition_.at_upper_wall() || flow.j < decomposition_.planes() - 1) return;
  for (int k = 0; k < nz; ++k) {
    const Real* v = velocity_.row(flow.at, k, 1);
    Real* excess = poisson_.excess_row(k);
    const Real over_gap =
        flow.upwards * static_cast<Real>(grid_.gap(decomposition_.first() + flow.j));
    for (int i = 0; i < nx; ++i) excess[i] = over_gap * v[i];
  }
}

/// Eliminates planes one above the other, all of whose rows have been taken.
template <class Real>
void PressureProjection<Real>::eliminate_planes(std::span<const Outflow> flows) {
  for (const Outflow& flow : flows) end_outflow(flow);
  clock_.lap(FlowPhase::divergence);
  for (int first = flows.front().j, end = flows.back().j + 1; first < end; first += tiles_.planes)
    poisson_.eliminate(first, std::min(first + tiles_.planes, end));
  clock_.lap(FlowPhase::elimination);
}

/// The same for planes whose u* is whole, in its place.
template <class Real>
void PressureProjection<Real>::eliminate_planes(int first, int end, double step) {
  std::vector<Outflow> flows;
  for (int begin = first; begin < end; begin += tiles_.planes) {
    flows.clear();
    for (int j = begin; j < std::min(begin + tiles_.planes, end); ++j) {
      flows.push_back(outflow(j, j, step));
      for (int k = 0; k < decomposition_.rows(); ++k) {
        const bool last = k + 1 == decomposition_.rows();
        ask_for(velocity_.row_block(last ? j + 1 : j, last ? 0 : k + 1), velocity_.row_size());
        take_row(flows.back(), k);
      }
    }
    eliminate_planes(flows);
  }
}

/// u = u* - step grad phi + shift; where the predictor moved the planes, each one back into its
/// place.
template <class Real>
void PressureProjection<Real>::correct(const Correction& correction) {
  sum_ = {};
  fastest_ = 0.0;
  const int planes = decomposition_.planes();
  if (!decomposition_.at_upper_wall()) {  // which the highest plane's correction needs
    poisson_.substitute(planes, planes + 1);
    const int rows = decomposition_.rows() + (poisson_.gives_to_front() ? 1 : 0);
    update_pressure(planes, 0, rows, correction);
  }
  for (int first = planes, end = planes; end > 0; end = first) {
    first = std::max(end - tiles_.planes, 0);
    poisson_.substitute(first, end);
    clock_.lap(FlowPhase::substitution);
    correct_planes(first, end, correction);
    clock_.lap(FlowPhase::correction);
  }
  velocity_.relabel(-correction.moved);
}

/// A few rows of each plane, from the highest one down, before the next rows: u* of a plane gives
/// way to u of the plane below while it is in the cache.
template <class Real>
void PressureProjection<Real>::correct_planes(int first, int end, const Correction& correction) {
  const int nz = decomposition_.rows();
  for (int begin = 0; begin < nz; begin += tiles_.rows) {
    const int stop = std::min(begin + tiles_.rows, nz);
    for (int j = end - 1; j >= first; --j) {
      for (int k = begin; k < stop; ++k) {
        if (k + 1 < stop)
          ask_for(velocity_.row_block(j, k + 1), velocity_.row_size());
        else if (j > first)
          ask_for(velocity_.row_block(j - 1, begin), velocity_.row_size());
        correct_row(j, k, correction);
      }
      const bool in_front = stop == nz && poisson_.gives_to_front();
      update_pressure(j, begin, in_front ? nz + 1 : stop, correction);
    }
  }
  for (int j = end - 1; j >= first; --j) walls_.close_plane(velocity_, j + correction.moved);
}

/// One row of it, with the row's share of what the last stage measures.
template <class Real>
void PressureProjection<Real>::correct_row(int j, int k, const Correction& correction) {
  const int nx = grid_.cells[0], global = decomposition_.first() + j;
  const bool under_wall = decomposition_.at_upper_wall() && j == decomposition_.planes() - 1;
  const Real* phi = poisson_.solution_row(j, k);
  Real* to = velocity_.row(j + correction.moved, k);
  bedload::correct_row(
      nx, static_cast<Real>(correction.step / grid_.h),
      static_cast<Real>(correction.step / grid_.h / grid_.gap(global)),
      static_cast<Real>(correction.shift), velocity_.component_stride(), velocity_.row(j, k), to,
      phi, under_wall ? phi : poisson_.solution_row(j + 1, k), poisson_.solution_row(j, k + 1));
  for (int c = 0; c < 3; ++c)
    walls_.close_row(to + static_cast<std::size_t>(c) * velocity_.component_stride(), c);
  if (!correction.measure) return;
  sum_ += row_sum(nx, to) * grid_.thickness(global);
  const Real stretch = static_cast<Real>(stretch_at(grid_, global));
  const Real fastest = largest_speed(nx, stretch, velocity_.component_stride(), to);
  fastest_ = std::max(fastest_, static_cast<double>(fastest));
}

/// p + s phi where the predictor had the old pressure gradient (s < 1 with spheres: the whole would
/// make them oscillate by their added mass, immersed_boundary/README.md), phi itself where it had
/// none (the projection then yields the same velocity, and phi of the last stage is the pressure).
template <class Real>
void PressureProjection<Real>::update_pressure(int j, int first_row, int end_row,
                                               const Correction& correction) {
  const PressureUse use =
      j < correction.pressure_planes ? correction.pressure : correction.pressure_above;
  if (use == PressureUse::none) return;
  const int nx = grid_.cells[0];
  const Real share = static_cast<Real>(correction.pressure_share);
  for (int k = first_row; k < end_row; ++k) {
    const Real* phi = poisson_.solution_row(j, k);
    Real* p = pressure_.row(j, k);
    if (use == PressureUse::replace)
      for (int i = 0; i < nx; ++i) p[i] = phi[i];
    else
      for (int i = 0; i < nx; ++i) p[i] += share * phi[i];
  }
  if (end_row >= decomposition_.rows()) walls_.close_scalar(pressure_, j);
}

template class PressureProjection<float>;
template class PressureProjection<double>;

}  // namespace bedload
