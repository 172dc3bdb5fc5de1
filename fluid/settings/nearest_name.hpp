#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Which of the known names a mistyped one may have been.
namespace bedload {

/// Number of single-letter edits between two names.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> previous(b.size() + 1), current(b.size() + 1);
  std::iota(previous.begin(), previous.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j)
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1,
                             previous[j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u)});
    std::swap(previous, current);
  }
  return previous[b.size()];
}

/// The candidate with the fewest edits to `name`, in its whole or, one edit dearer, without the
/// group in front; empty where there is none.
inline std::string nearest(std::string_view name, const std::set<std::string>& known) {
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : known) {
    const std::string_view own = std::string_view(candidate).substr(candidate.rfind('.') + 1);
    const std::size_t distance =
        std::min(edit_distance(name, candidate), edit_distance(name, own) + 1);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace bedload
