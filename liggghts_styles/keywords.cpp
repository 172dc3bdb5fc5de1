#include "liggghts_styles/keywords.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <string>

#include "error.h"
#include "lammps.h"

namespace bedload {

void stop_run(LAMMPS_NS::LAMMPS* lmp, std::string_view sentence) {
  const std::string text(sentence);
  lmp->error->all(__FILE__, __LINE__, text.c_str());
  std::abort();  // Error::all does not return
}

double read_number(LAMMPS_NS::LAMMPS* lmp, std::string_view style, std::string_view keyword,
                   std::string_view text) {
  const std::string word(text);
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  if (word.empty() || *end != '\0' || !std::isfinite(value)) {
    stop_run(lmp, fmt::format("{}: {} needs a number, found '{}'", style, keyword, word));
  }
  return value;
}

std::string allowed_text(const NumberKeyword& keyword) {
  std::string text =
      fmt::format("{} {}", keyword.or_equal ? "at least" : "more than", keyword.lower);
  if (std::isfinite(keyword.upper)) text += fmt::format(" and at most {}", keyword.upper);
  return text;
}

void check_number(LAMMPS_NS::LAMMPS* lmp, std::string_view style, const NumberKeyword& keyword,
                  double value) {
  const bool above = keyword.or_equal ? value >= keyword.lower : value > keyword.lower;
  if (above && value <= keyword.upper) return;
  stop_run(lmp, fmt::format("{}: {} has to be {}, found {}", style, keyword.name,
                            allowed_text(keyword), value));
}

std::string describe_style(const StyleHelp& style) {
  std::string text = fmt::format("{}\n    {}\n", style.name, style.meaning);
  for (std::size_t begin = 0; begin < style.syntax.size();) {
    const std::size_t end = std::min(style.syntax.find('\n', begin), style.syntax.size());
    text += fmt::format("    {}\n", style.syntax.substr(begin, end - begin));
    begin = end + 1;
  }
  for (const WordKeyword& word : style.words)
    text += fmt::format("  {}\n    {}\n    text; default {}\n", word.name, word.meaning,
                        word.preset_text);
  for (const NumberKeyword& number : style.numbers)
    text += fmt::format("  {}\n    {}\n    unit {}; {}; default {}\n", number.name, number.meaning,
                        number.unit, allowed_text(number),
                        number.preset_text.empty() ? fmt::format("{}", number.preset)
                                                   : std::string(number.preset_text));
  return text;
}

void check_numbers(LAMMPS_NS::LAMMPS* lmp, std::string_view style,
                   std::span<const NumberKeyword> keywords, std::span<char*> arguments) {
  for (std::size_t n = 0; n < arguments.size(); n += 2) {
    for (const NumberKeyword& keyword : keywords) {
      if (keyword.name != arguments[n]) continue;
      if (n + 1 == arguments.size()) {
        stop_run(lmp, fmt::format("{}: {} needs a number behind it", style, keyword.name));
      }
      check_number(lmp, style, keyword, read_number(lmp, style, keyword.name, arguments[n + 1]));
    }
  }
}

}  // namespace bedload
