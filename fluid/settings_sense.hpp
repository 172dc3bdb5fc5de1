#pragma once

#include "fluid/settings.hpp"

namespace bedload {

/// Throws UserError where numbers that are allowed one by one make a run that no machine can do.
void check_sense(const Settings& settings);

/// Fewest bytes that the fields of a run take on all ranks together: velocity, its tendency,
/// pressure and the transformed right-hand side.
double least_field_bytes(const Settings& settings);

}  // namespace bedload
