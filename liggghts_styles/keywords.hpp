#pragma once

#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>

namespace LAMMPS_NS {
class LAMMPS;
}

/// Keywords and their values in LIGGGHTS input lines, checked: LIGGGHTS itself reads text as 0.
namespace bedload {

/// The number written in `text`. Ends the run with one sentence (style, keyword, value found) if it
/// is not a finite number.
double read_number(LAMMPS_NS::LAMMPS* lmp, std::string_view style, std::string_view keyword,
                   std::string_view text);

inline constexpr double no_limit = std::numeric_limits<double>::infinity();

/// A keyword that takes a number. Declared once per style: what is read, checked and printed by
/// `bedload-dem --help-styles` comes from here.
struct NumberKeyword {
  std::string_view name;
  double lower;                    ///< allowed: above this,
  bool or_equal;                   ///< or equal to it if this is set,
  double upper;                    ///< and not above this
  double preset = 0;               ///< value without the keyword
  std::string_view preset_text{};  ///< where that is worked out: from what
  std::string_view unit = "-";
  std::string_view meaning{};
  bool whole = false;  ///< no fractions
};

/// What is allowed, in words.
std::string allowed_text(const NumberKeyword& keyword);

/// A keyword that takes a word.
struct WordKeyword {
  std::string_view name, preset_text, meaning;
};

/// A keyword that takes one of several words.
struct ChoiceKeyword {
  std::string_view name;
  std::span<const std::string_view> choices;
  std::size_t preset;  ///< which one without the keyword
  std::string_view meaning;
};

/// A style or command as the help prints it.
struct StyleHelp {
  std::string_view name;     ///< kind and name: "normal model actm"
  std::string_view meaning;  ///< one sentence
  std::string_view syntax;   ///< lines of a script
  std::span<const NumberKeyword> numbers{};
  std::span<const WordKeyword> words{};
  std::span<const ChoiceKeyword> choices{};
};

std::string describe_style(const StyleHelp& style);

/// Makes LIGGGHTS read the keyword of a contact model (`settings` of registerSettings).
template <class Settings>
void read_setting(Settings& settings, const NumberKeyword& keyword, double& value) {
  settings.registerDoubleSetting(std::string(keyword.name), value, keyword.preset);
}

/// Ends the run with one sentence if `value` is not what the keyword allows.
void check_number(LAMMPS_NS::LAMMPS* lmp, std::string_view style, const NumberKeyword& keyword,
                  double value);

/// Checks those of the pairs "keyword value" among `arguments` that are in `keywords`; leaves
/// others to whoever knows them. @param style name for the sentence
void check_numbers(LAMMPS_NS::LAMMPS* lmp, std::string_view style,
                   std::span<const NumberKeyword> keywords, std::span<char*> arguments);

/// The same for words that have to be one of the choices.
void check_choices(LAMMPS_NS::LAMMPS* lmp, std::string_view style,
                   std::span<const ChoiceKeyword> keywords, std::span<char*> arguments);

/// "unknown keyword 'rage', the nearest is 'range' (there are range and viscosity)".
std::string unknown_keyword(std::string_view found, std::span<const std::string> known);

/// The pairs "keyword value" of a line, in any order, as a style declares them. Ends the run with
/// one sentence where a keyword is unknown, comes twice, has no value, or one that is not allowed.
class Arguments {
 public:
  Arguments(LAMMPS_NS::LAMMPS* lmp, const StyleHelp& style, std::span<char*> line);

  /// The value given, or the preset of the declaration.
  double number(std::string_view name) const;
  /// The word given, or "".
  std::string word(std::string_view name) const;
  bool has(std::string_view name) const { return given_.contains(name); }

 private:
  const StyleHelp& style_;
  std::map<std::string_view, std::string> given_;
};

/// Ends the run on all ranks with one sentence, behind which LIGGGHTS names the line of the source.
/// To be called on every rank.
[[noreturn]] void stop_run(LAMMPS_NS::LAMMPS* lmp, std::string_view sentence,
                           const char* file = __builtin_FILE(), int line = __builtin_LINE());

}  // namespace bedload
