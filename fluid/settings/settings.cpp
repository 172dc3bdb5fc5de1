#include "fluid/settings/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string_view>

#include "fluid/settings/declared_keys.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/settings/input_file.hpp"
#include "fluid/settings/nearest_name.hpp"

namespace bedload {
namespace {

template <class Enum>
std::string word_list(const Words<Enum>& words) {
  std::string list;
  for (const auto& entry : words)
    list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", entry.first);
  return list;
}

/// Takes every declared key out of the TOML table; what is left over is unknown.
class Reader {
 public:
  Reader(const toml::table& table, std::string file) : table_(table), file_(std::move(file)) {}

  void text(std::string_view name, std::string& value, std::string_view) {
    if (const toml::node* node = take(name)) {
      const auto found = node->value_exact<std::string>();
      if (!found) fail(name, *node, "a text in quotes");
      value = *found;
    }
  }
  template <class Integer>
  void integer(std::string_view name, Integer& value, std::string_view, Range range,
               std::string_view) {
    if (const toml::node* node = take(name)) value = read_integer<Integer>(name, *node, range);
  }
  void number(std::string_view name, double& value, std::string_view, Range range, Need need,
              std::string_view) {
    if (const toml::node* node = take(name, need)) value = read_number(name, *node, range);
  }
  void integers(std::string_view name, std::array<int, 3>& values, std::string_view, Range range,
                Need need, std::string_view) {
    if (const toml::node* node = take(name, need)) {
      const toml::array& list = list_of_three(name, *node);
      for (std::size_t d = 0; d < 3; ++d) values[d] = read_integer<int>(name, list[d], range);
    }
  }
  void numbers(std::string_view name, std::array<double, 3>& values, std::string_view, Range range,
               Need need, std::string_view) {
    if (const toml::node* node = take(name, need)) {
      const toml::array& list = list_of_three(name, *node);
      for (std::size_t d = 0; d < 3; ++d) values[d] = read_number(name, list[d], range);
    }
  }
  void list(std::string_view name, std::vector<double>& values, std::string_view, Range range,
            std::string_view) {
    const toml::node* node = take(name);
    if (!node) return;
    const toml::array* list = node->as_array();
    if (!list) fail(name, *node, "a list of numbers in brackets");
    values.clear();
    for (const toml::node& entry : *list) values.push_back(read_number(name, entry, range));
  }
  template <class Enum>
  void word(std::string_view name, Enum& value, const Words<Enum>& words, std::string_view) {
    if (const toml::node* node = take(name)) value = read_word(name, *node, words);
  }
  template <class Enum>
  void words(std::string_view name, std::array<Enum, 2>& ends, const Words<Enum>& words,
             std::string_view) {
    const toml::node* node = take(name);
    if (!node) return;
    if (const toml::array* list = node->as_array(); list && list->size() == 2) {
      for (std::size_t e = 0; e < 2; ++e) ends[e] = read_word(name, (*list)[e], words);
    } else {
      ends.fill(read_word(name, *node, words));
    }
  }

  /// Throws on the first key of the file that is not declared, and on a required one that is not
  /// there.
  void finish() const {
    if (missing_.empty()) return check_unknown();
    std::set<std::string> unknown;
    each_unknown(table_, "",
                 [&](const std::string& name, const toml::node&) { unknown.insert(name); });
    const std::string meant = nearest(missing_, unknown);
    throw UserError(
        fmt::format("{}: the key '{}' is missing{}.", file_, missing_,
                    meant.empty() ? "" : fmt::format("; the unknown '{}' may be meant", meant)));
  }

 private:
  const toml::node* take(std::string_view name, Need need = Need::optional) {
    declared_.insert(std::string(name));
    const toml::node* node = table_.at_path(name).node();
    if (!node && need == Need::required && missing_.empty()) missing_ = name;
    return node;
  }
  [[noreturn]] void fail(std::string_view name, const toml::node& node,
                         std::string_view allowed) const {
    std::ostringstream found;
    node.visit([&found](const auto& n) { found << n; });
    throw UserError(
        fmt::format("{}: '{}' is {}, but must be {}.", place(node), name, found.str(), allowed));
  }
  std::string place(const toml::node& node) const {
    const toml::source_region& source = node.source();
    if (!source.path || *source.path != file_) return file_ + " with --set";
    return fmt::format("{}, line {}", file_, source.begin.line);
  }
  template <class Integer>
  Integer read_integer(std::string_view name, const toml::node& node, Range range) const {
    const auto found = node.value_exact<std::int64_t>();
    if (!found || !range.holds(static_cast<double>(*found)))
      fail(name, node, fmt::format("a whole number, {}", range.text()));
    return static_cast<Integer>(*found);
  }
  double read_number(std::string_view name, const toml::node& node, Range range) const {
    const auto found = node.is_number() ? node.value<double>() : std::nullopt;
    if (!found || !std::isfinite(*found) || !range.holds(*found))
      fail(name, node, fmt::format("a number, {}", range.text()));
    return *found;
  }
  const toml::array& list_of_three(std::string_view name, const toml::node& node) const {
    const toml::array* list = node.as_array();
    if (!list || list->size() != 3) fail(name, node, "a list of three numbers");
    return *list;
  }
  template <class Enum>
  Enum read_word(std::string_view name, const toml::node& node, const Words<Enum>& words) const {
    const auto found = node.value_exact<std::string>();
    for (const auto& [text, value] : words)
      if (found && *found == text) return value;
    fail(name, node, "one of " + word_list(words));
  }
  /// What stands in brackets above keys: grid, boundary ...
  std::set<std::string> groups() const {
    std::set<std::string> found;
    for (const std::string& name : declared_)
      if (const std::size_t dot = name.find('.'); dot != std::string::npos)
        found.insert(name.substr(0, dot));
    return found;
  }
  /// Hands (name, node) of each key that is not declared to `visit`.
  template <class Visit>
  void each_unknown(const toml::table& table, const std::string& prefix, Visit visit) const {
    for (const auto& [key, node] : table) {
      const std::string name = prefix + std::string(key.str());
      if (declared_.count(name)) continue;
      if (node.is_table() && groups().count(name))
        each_unknown(*node.as_table(), name + ".", visit);
      else
        visit(name, node);
    }
  }
  void check_unknown() const {
    each_unknown(table_, "", [this](const std::string& name, const toml::node& node) {
      if (node.is_table())
        throw UserError(
            fmt::format("{}: unknown group of keys '[{}]'; the nearest known one is '[{}]'.",
                        place(node), name, nearest(name, groups())));
      throw UserError(fmt::format("{}: unknown key '{}'; the nearest known one is '{}'.",
                                  place(node), name, nearest(name, declared_)));
    });
  }

  const toml::table& table_;
  std::string file_;
  std::set<std::string> declared_;
  std::string missing_;  ///< the first required key that is not there
};

template <class Enum>
std::string_view word_of(const Enum& value, const Words<Enum>& words) {
  for (const auto& [text, candidate] : words)
    if (candidate == value) return text;
  return "";
}

/// Hands every key's present value as TOML text to `line(name, value, unit, allowed, meaning)`.
template <class Line>
class Writer {
 public:
  explicit Writer(Line line) : line_(std::move(line)) {}
  void text(std::string_view name, const std::string& value, std::string_view meaning) {
    std::ostringstream quoted;
    quoted << toml::value<std::string>(value);
    line_(name, quoted.str(), "-", "text", meaning);
  }
  template <class Integer>
  void integer(std::string_view name, Integer value, std::string_view unit, Range range,
               std::string_view meaning) {
    line_(name, fmt::format("{}", value), unit, range.text(), meaning);
  }
  void number(std::string_view name, double value, std::string_view unit, Range range, Need need,
              std::string_view meaning) {
    line_(name, toml_number(value), unit, allowed(range, need), meaning);
  }
  void integers(std::string_view name, const std::array<int, 3>& values, std::string_view unit,
                Range range, Need need, std::string_view meaning) {
    line_(name, fmt::format("[{}]", fmt::join(values, ", ")), unit, allowed(range, need), meaning);
  }
  void numbers(std::string_view name, const std::array<double, 3>& values, std::string_view unit,
               Range range, Need need, std::string_view meaning) {
    line_(name,
          fmt::format("[{}, {}, {}]", toml_number(values[0]), toml_number(values[1]),
                      toml_number(values[2])),
          unit, allowed(range, need), meaning);
  }
  void list(std::string_view name, const std::vector<double>& values, std::string_view unit,
            Range range, std::string_view meaning) {
    std::vector<std::string> numbers;
    numbers.reserve(values.size());
    for (const double value : values) numbers.push_back(toml_number(value));
    line_(name, fmt::format("[{}]", fmt::join(numbers, ", ")), unit,
          fmt::format("any number of numbers, each {}", range.text()), meaning);
  }
  template <class Enum>
  void word(std::string_view name, const Enum& value, const Words<Enum>& words,
            std::string_view meaning) {
    line_(name, fmt::format("\"{}\"", word_of(value, words)), "-", word_list(words), meaning);
  }
  template <class Enum>
  void words(std::string_view name, const std::array<Enum, 2>& ends, const Words<Enum>& words,
             std::string_view meaning) {
    line_(name, fmt::format("[\"{}\", \"{}\"]", word_of(ends[0], words), word_of(ends[1], words)),
          "-", word_list(words), meaning);
  }

 private:
  static std::string allowed(Range range, Need need) {
    return range.text() + (need == Need::required ? ", required" : "");
  }
  /// Shortest text that reads back as the same double and is a TOML float.
  static std::string toml_number(double value) {
    std::string text = fmt::format("{}", value);
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
    return text;
  }
  Line line_;
};

/// Lays `extra` over `base`, table by table.
void merge(toml::table& base, const toml::table& extra) {
  for (const auto& [key, node] : extra) {
    if (node.is_table() && base[key].is_table())
      merge(*base[key].as_table(), *node.as_table());
    else
      base.insert_or_assign(key, node);
  }
}

/// Refuses keys of more parts (a.b.c...) than anybody means: the TOML library reads them by a
/// recursion that overflows the stack. Looks at dots outside of quotes that follow each other
/// without anything but names and spaces between them.
void check_depth(std::string_view text, const std::string& where) {
  constexpr int most_parts = 100;
  int dots = 0, line = 1;
  char quote = 0;
  for (const char c : text) {
    if (c == '\n') {
      ++line;
      dots = 0;
      quote = 0;
    } else if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '.') {
      if (++dots > most_parts)
        throw UserError(
            fmt::format("{}, line {}: a key has more than {} parts.", where, line, most_parts));
    } else if (c == '=' || c == ',' || c == '{' || c == '[' || c == ']' || c == '#') {
      dots = 0;
    }
  }
}

toml::table parse(std::string_view text, const std::string& file) {
  check_depth(text, file);
  return toml::parse(text, file);
}

/// `key=word` as `key="word"`, where the word needs no quotes to be told from TOML's own values;
/// nothing where it is none.
std::optional<std::string> quoted(const std::string& text) {
  static const std::regex bare(
      R"(\s*([A-Za-z0-9_.\-"']+)\s*=\s*([A-Za-z_./][A-Za-z0-9_./+\-]*)\s*)");
  std::smatch match;
  if (!std::regex_match(text, match, bare)) return std::nullopt;
  return fmt::format("{}=\"{}\"", match[1].str(), match[2].str());
}

toml::table parse_override(const std::string& text) {
  check_depth(text, "--set");
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    if (const auto with_quotes = quoted(text)) return toml::parse(*with_quotes);
    throw UserError(fmt::format("--set {}: {}; write it as in TOML, for instance time.end=20.",
                                text, error.description()));
  }
}

}  // namespace

double Settings::constant_driving() const {
  if (flow.driving == Driving::pressure_gradient) return flow.pressure_gradient;
  if (flow.driving == Driving::gravity) return fluid.density * fluid.gravity[0];
  return 0.0;
}

double Settings::driven_height() const {
  constexpr double near = 0.05;  // the top of a bed of grains is known no better
  if (boundary.y[0] != Wall::no_slip || boundary.y[1] != Wall::no_slip) return reference.height;
  const double clear = grid.length[1] - start.height;
  const bool is_half = std::abs(2.0 * reference.height - clear) <= near * clear;
  return is_half ? reference.height : 0.5 * reference.height;
}

std::string Settings::beside(const std::string& name) const {
  return (std::filesystem::path(file).parent_path() / name).string();
}

Settings parse_settings(const std::string& text, const std::string& file,
                        const std::vector<std::string>& overrides) {
  toml::table table;
  try {
    table = parse(text, file);
  } catch (const toml::parse_error& error) {
    throw UserError(
        fmt::format("{}, line {}: {}.", file, error.source().begin.line, error.description()));
  }
  for (const std::string& override_text : overrides) merge(table, parse_override(override_text));
  Settings settings;
  settings.file = file;
  Reader reader(table, file);
  declare_keys(settings, reader);
  reader.finish();
  return settings;
}

Settings read_settings(const std::string& file, const std::vector<std::string>& overrides) {
  std::ifstream stream = open_input(file);
  std::stringstream text;
  text << stream.rdbuf();
  Settings settings = parse_settings(text.str(), file, overrides);
  settings.overrides = overrides;
  return settings;
}

std::string settings_as_toml(const Settings& settings) {
  std::string out;
  Settings copy = settings;
  Writer writer([&out](std::string_view name, const std::string& value, std::string_view unit,
                       const std::string&, std::string_view meaning) {
    out += fmt::format("{} = {}  # {}[{}]\n", name, value, meaning, unit);
  });
  declare_keys(copy, writer);
  return out;
}

std::vector<std::pair<std::string, std::string>> settings_as_pairs(const Settings& settings) {
  std::vector<std::pair<std::string, std::string>> pairs;
  Settings copy = settings;
  Writer writer([&pairs](std::string_view name, const std::string& value, std::string_view,
                         const std::string&,
                         std::string_view) { pairs.emplace_back(name, value); });
  declare_keys(copy, writer);
  return pairs;
}

std::string describe_keys() {
  std::string out;
  Settings defaults;
  Writer writer([&out](std::string_view name, const std::string& value, std::string_view unit,
                       const std::string& allowed, std::string_view meaning) {
    out += fmt::format("{}\n    {}\n    unit {}; {}; default {}\n", name, meaning, unit, allowed,
                       allowed.ends_with("required") ? "none" : value);
  });
  declare_keys(defaults, writer);
  return out;
}

}  // namespace bedload
