#pragma once

#include <span>
#include <vector>

#include "coupling/fluid_side.hpp"
#include "fluid/output/effects_table.hpp"
#include "fluid/settings.hpp"

namespace bedload {

/// What this run computes and what not, and why. `spheres`: all; `dem` is nullptr without LIGGGHTS.
std::vector<EffectRow> effects_of(const Settings& settings, std::span<const SphereState> spheres,
                                  const Acquaintance* dem);

}  // namespace bedload
