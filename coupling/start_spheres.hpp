#pragma once

#include <span>

#include "fluid/settings.hpp"
#include "fluid/sphere.hpp"

namespace bedload {

/// Throws UserError with one sentence when a mobile sphere starts inside another sphere or a wall
/// by more than half a radius, which nobody means. What a bed's spheres do among themselves and
/// with walls is nobody's business: they stay.
void check_start(const Settings& settings, std::span<const SphereState> spheres);

}  // namespace bedload
