#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "coupling/exchange/fluid_side.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"
#include "fluid/output/effects_table.hpp"
#include "fluid/output/timing.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// How many spheres a run begins with, and how large they are.
struct SphereNumbers {
  std::int64_t fixed = 0, mobile = 0;
  double widest = 0.0;  ///< largest diameter [L], 0 without spheres
  std::int64_t all() const { return fixed + mobile; }
};

/// What this run computes and what not, and why; `dem` is nullptr without LIGGGHTS.
std::vector<EffectRow> effects_of(const Settings& settings, const SphereNumbers& spheres,
                                  const PartnerScene* dem);

/// Puts each effect's share of the time beside it, where it can be told apart. `grain_seconds`:
/// that LIGGGHTS has moved grains; `markers`: mean over the ranks.
void add_shares(std::vector<EffectRow>& effects, std::span<const TimingRow> times,
                const MarkerSeconds& markers, double grain_seconds);

}  // namespace bedload
