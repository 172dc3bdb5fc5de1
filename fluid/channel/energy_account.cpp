#include "fluid/channel/energy_account.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "fluid/channel/diagnostics.hpp"
#include "fluid/channel/runge_kutta.hpp"

namespace bedload {
namespace {

/// result = change(velocity, result) in all own cells.
template <class Real, class Change>
void renew(Field<Real>& result, const Field<Real>& velocity, const Change& change) {
  for (int j = 0; j < velocity.planes(); ++j)
    for (int k = 0; k < velocity.nz(); ++k)
      for (int c = 0; c < velocity.components(); ++c) {
        const Real* from = velocity.row(j, k, c);
        Real* to = result.row(j, k, c);
        for (int i = 0; i < velocity.nx(); ++i) to[i] = change(from[i], to[i]);
      }
}

}  // namespace

template <class Real>
EnergyAccount<Real>::EnergyAccount(const Grid& grid, const Decomposition& decomposition)
    : grid_(grid),
      decomposition_(decomposition),
      before_(grid, decomposition.extent(), 3),
      earlier_(grid, decomposition.extent(), 3),
      kick_(grid, decomposition.extent(), 3) {}

template <class Real>
void EnergyAccount<Real>::begin_stage(const Field<Real>& velocity, int stage) {
  if (stage == 0) work_ = {.forcing = 0.0, .viscous = 0.0, .convective = 0.0};
  std::swap(before_, earlier_);
  for (int j = -1; j <= velocity.planes(); ++j)
    for (int k = -1; k <= velocity.nz(); ++k)
      std::copy_n(velocity.row_block(j, k), velocity.row_size(), before_.row_block(j, k));
  forced_ = false;
}

template <class Real>
void EnergyAccount<Real>::predicted(const Field<Real>& velocity) {
  renew(kick_, velocity, [](Real now, Real) { return now; });
}

template <class Real>
void EnergyAccount<Real>::forced(const Field<Real>& velocity) {
  renew(kick_, velocity, [](Real now, Real before) { return now - before; });
  forced_ = true;
}

template <class Real>
void EnergyAccount<Real>::end_stage(const Field<Real>& velocity, int stage, double dt,
                                    const Settings::Fluid& fluid, bool implicit) {
  const double mass = grid_.volume();
  if (forced_)
    work_.forcing += 0.5 *
                     (product_integral(kick_, before_, grid_, decomposition_) +
                      product_integral(kick_, velocity, grid_, decomposition_)) /
                     (mass * dt);
  Field<Real>& mean = kick_;
  renew(mean, before_, [](Real now, Real) { return now; });
  renew(mean, velocity, [](Real now, Real before) { return Real(0.5) * (before + now); });
  const auto tendency = [&](double weight, const Field<Real>& from) {
    if (weight == 0.0) return;
    if (fluid.convection)
      work_.convective +=
          weight / (grid_.h * mass) * convective_power_integral(mean, from, grid_, decomposition_);
    work_.viscous += weight * fluid.kinematic_viscosity / (grid_.h * grid_.h * mass) *
                     viscous_power_integral(mean, from, grid_, decomposition_);
  };
  const Stage& weights = runge_kutta[static_cast<std::size_t>(stage)];
  tendency(weights.gamma, before_);
  tendency(weights.zeta, earlier_);
  if (!implicit) return;
  work_.viscous = std::numeric_limits<double>::quiet_NaN();
  // The markers' kept force acts within the predictor.
  if (forced_) work_.forcing = std::numeric_limits<double>::quiet_NaN();
}

template class EnergyAccount<float>;
template class EnergyAccount<double>;

}  // namespace bedload
