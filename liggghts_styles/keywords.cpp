#include "liggghts_styles/keywords.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "error.h"
#include "lammps.h"

namespace bedload {
namespace {

/// Number of single-letter edits between two names. (The flow solver has its own for its keys:
/// neither folder knows the other.)
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, changed}));
    }
  }
  return row.back();
}

template <class Keyword>
const Keyword* find_keyword(std::span<const Keyword> keywords, std::string_view name) {
  const auto found = std::find_if(keywords.begin(), keywords.end(),
                                  [&](const Keyword& known) { return known.name == name; });
  return found == keywords.end() ? nullptr : &*found;
}

}  // namespace

void stop_run(LAMMPS_NS::LAMMPS* lmp, std::string_view sentence, const char* file, int line) {
  const std::string text(sentence);
  lmp->error->all(file, line, text.c_str());
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
  std::string text = fmt::format("{}{} {}", keyword.whole ? "a whole number, " : "",
                                 keyword.or_equal ? "at least" : "more than", keyword.lower);
  if (std::isfinite(keyword.upper)) text += fmt::format(" and at most {}", keyword.upper);
  return text;
}

void check_number(LAMMPS_NS::LAMMPS* lmp, std::string_view style, const NumberKeyword& keyword,
                  double value) {
  const bool above = keyword.or_equal ? value >= keyword.lower : value > keyword.lower;
  const bool fits = !keyword.whole || value == std::floor(value);
  if (above && fits && value <= keyword.upper) return;
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
  for (const ChoiceKeyword& choice : style.choices)
    text += fmt::format("  {}\n    {}\n    unit -; {}; default {}\n", choice.name, choice.meaning,
                        fmt::join(choice.choices, ", "), choice.choices[choice.preset]);
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
      if (n + 1 == arguments.size())
        stop_run(lmp, fmt::format("{}: {} needs a number behind it", style, keyword.name));
      check_number(lmp, style, keyword, read_number(lmp, style, keyword.name, arguments[n + 1]));
    }
  }
}

void check_choices(LAMMPS_NS::LAMMPS* lmp, std::string_view style,
                   std::span<const ChoiceKeyword> keywords, std::span<char*> arguments) {
  for (std::size_t n = 0; n < arguments.size(); n += 2) {
    for (const ChoiceKeyword& keyword : keywords) {
      if (keyword.name != arguments[n]) continue;
      const std::string_view found = n + 1 < arguments.size() ? arguments[n + 1] : "";
      if (std::find(keyword.choices.begin(), keyword.choices.end(), found) != keyword.choices.end())
        continue;
      stop_run(lmp, fmt::format("{}: {} has to be one of {}, found '{}'", style, keyword.name,
                                fmt::join(keyword.choices, ", "), found));
    }
  }
}

std::string unknown_keyword(std::string_view found, std::span<const std::string> known) {
  const auto nearest = std::min_element(
      known.begin(), known.end(),
      [&](const auto& a, const auto& b) { return edits(found, a) < edits(found, b); });
  if (nearest == known.end()) return fmt::format("unknown keyword '{}', there is none here", found);
  const std::string list =
      known.size() > 1 ? fmt::format(" (there are {})", fmt::join(known.begin(), known.end(), ", "))
                       : "";
  return fmt::format("unknown keyword '{}', the nearest is '{}'{}", found, *nearest, list);
}

Arguments::Arguments(LAMMPS_NS::LAMMPS* lmp, const StyleHelp& style, std::span<char*> line)
    : style_(style) {
  for (std::size_t n = 0; n < line.size(); n += 2) {
    const std::string_view name(line[n]);
    const NumberKeyword* const number = find_keyword(style.numbers, name);
    const WordKeyword* const word = find_keyword(style.words, name);
    if (number == nullptr && word == nullptr) {
      std::vector<std::string> known;
      for (const NumberKeyword& k : style.numbers) known.emplace_back(k.name);
      for (const WordKeyword& k : style.words) known.emplace_back(k.name);
      stop_run(lmp, fmt::format("{}: {}", style.name, unknown_keyword(name, known)));
    }
    if (word != nullptr && n + 1 == line.size())
      stop_run(lmp, fmt::format("{}: {} needs a word behind it", style.name, name));
    if (number != nullptr) check_numbers(lmp, style.name, {number, 1}, line.subspan(n));
    if (given_.contains(name))
      stop_run(lmp,
               fmt::format("{}: {} stands there twice; leave out one of them", style.name, name));
    given_[name] = line[n + 1];
  }
}

double Arguments::number(std::string_view name) const {
  const auto found = given_.find(name);
  if (found != given_.end()) return std::stod(found->second);
  return find_keyword(style_.numbers, name)->preset;
}

std::string Arguments::word(std::string_view name) const {
  const auto found = given_.find(name);
  return found == given_.end() ? "" : found->second;
}

}  // namespace bedload
