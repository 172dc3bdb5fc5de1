#pragma once

#include <string>
#include <vector>

#include "fluid/output/derived_numbers.hpp"
#include "fluid/settings.hpp"

namespace bedload {

/// One sentence for each setting that is allowed but hardly meant: numbers that make little
/// physical sense, and keys that have no effect in this scene. Printed as warnings at the start.
std::vector<std::string> doubts(const Settings& settings, const DerivedNumbers& numbers);

}  // namespace bedload
