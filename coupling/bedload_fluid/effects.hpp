#pragma once

#include <span>
#include <vector>

#include "coupling/exchange/fluid_side.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"
#include "fluid/output/effects_table.hpp"
#include "fluid/output/timing.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// What this run computes and what not, and why. `spheres`: all; `dem` is nullptr without LIGGGHTS.
std::vector<EffectRow> effects_of(const Settings& settings, std::span<const SphereState> spheres,
                                  const PartnerScene* dem);

/// Puts each effect's share of the time beside it, where it can be told apart. `grain_seconds`:
/// that LIGGGHTS has moved grains; `markers`: mean over the ranks.
void add_shares(std::vector<EffectRow>& effects, std::span<const TimingRow> times,
                const MarkerSeconds& markers, double grain_seconds);

}  // namespace bedload
