#pragma once

#include "fluid/settings.hpp"

namespace bedload {

/// What no single key can tell: the keys against each other. Throws UserError.
void check_together(const Settings& settings);

}  // namespace bedload
