#pragma once

#include <optional>
#include <string>
#include <vector>

namespace bedload {

/// One effect of a scene: whether it is computed, why, and at the end its share of the time.
struct EffectRow {
  std::string effect;
  std::string state;  ///< "on", "off", or its value
  std::string why;
  std::optional<double> share;  ///< of the wall clock, 0 to 1
};

/// The rows as a table for the terminal; the column of shares only where one is known.
std::string effects_table(const std::vector<EffectRow>& rows);

}  // namespace bedload
