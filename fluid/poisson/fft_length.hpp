#pragma once

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>

namespace bedload {

/// Whether FFTW has fast code for a transform of n points: 2^a 3^b 5^c 7^d 11^e 13^f with e + f at
/// most 1 (FFTW 3.3 manual, section 4.3.1). Others work and take longer.
constexpr bool is_fast_length(int n) {
  for (const int factor : {2, 3, 5, 7})
    while (n % factor == 0) n /= factor;
  return n == 1 || n == 11 || n == 13;
}

/// The nearest length that is fast, the longer one of two; nothing where n is fast itself.
constexpr std::optional<int> faster_length(int n) {
  if (is_fast_length(n)) return std::nullopt;
  int distance = 1;
  while (!is_fast_length(n + distance) && !is_fast_length(n - distance)) ++distance;
  return is_fast_length(n + distance) ? n + distance : n - distance;
}

/// A sentence for each of x and z whose number of cells makes the pressure's transforms slow; y has
/// none.
inline std::string length_hints(const std::array<int, 3>& cells) {
  std::string text;
  for (const std::size_t d : {0u, 2u})
    if (const auto better = faster_length(cells[d]))
      text += fmt::format(
          "hint: {} cells along {} have a large prime factor, which is slow to transform; {} would "
          "be faster (grid.cells, and grid.length with it).\n",
          cells[d], "xyz"[d], *better);
  return text;
}

}  // namespace bedload
