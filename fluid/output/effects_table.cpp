#include "fluid/output/effects_table.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace bedload {

std::string effects_table(const std::vector<EffectRow>& rows) {
  std::size_t effect_width = 6, state_width = 5;
  bool has_share = false;
  for (const EffectRow& row : rows) {
    effect_width = std::max(effect_width, row.effect.size());
    state_width = std::max(state_width, row.state.size());
    has_share = has_share || row.share;
  }
  const auto line = [&](const std::string& effect, const std::string& state,
                        const std::string& share, const std::string& why) {
    return fmt::format("{:<{}}  {:<{}}  {}{}\n", effect, effect_width, state, state_width,
                       has_share ? fmt::format("{:>6}  ", share) : "", why);
  };
  std::string text = line("effect", "state", "time", "why");
  for (const EffectRow& row : rows)
    text += line(row.effect, row.state, row.share ? fmt::format("{:.1f}%", 100.0 * *row.share) : "",
                 row.why);
  return text;
}

}  // namespace bedload
