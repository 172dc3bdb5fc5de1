#pragma once

#include <vector>

#include "coupling/fluid_side.hpp"
#include "fluid/output/effects_table.hpp"
#include "fluid/settings.hpp"

namespace bedload {

/// What this run computes and what not, and why. `dem` is nullptr without LIGGGHTS.
std::vector<EffectRow> effects_of(const Settings& settings, const Acquaintance* dem);

}  // namespace bedload
