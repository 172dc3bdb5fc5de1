#pragma once

#include <span>
#include <string>
#include <vector>

#include "fluid/grid/sphere.hpp"
#include "fluid/settings/settings.hpp"
#include "fluid/validation/derived_numbers.hpp"

namespace bedload {

/// One sentence for each setting that is allowed but makes little physical sense, or has no effect
/// in this scene. Printed at the start.
std::vector<std::string> warnings(const Settings& settings, const DerivedNumbers& numbers);

/// One sentence for each thing that the scheme does not do well with such mobile spheres; the run
/// goes on nevertheless. `spheres`: all of the run. Printed at the start, and whenever spheres come
/// or change.
std::vector<std::string> warnings(const Settings& settings, std::span<const SphereState> spheres);

}  // namespace bedload
