#pragma once

#include <string>

#include "fluid/settings/settings.hpp"
#include "fluid/validation/derived_numbers.hpp"

namespace bedload {

/// The derived numbers, one "# derived.name = value  # meaning" per line. Comments, because they
/// follow from the keys: a file with them can be run again.
std::string derived_as_comments(const DerivedNumbers& numbers);

/// Writes folder/settings.toml: every value in force, files with their whole path, since they stand
/// beside another fluid.toml; then the derived numbers. For the first rank;
/// throws UserError.
void write_settings_file(const std::string& folder, const Settings& settings,
                         const DerivedNumbers& numbers);

}  // namespace bedload
