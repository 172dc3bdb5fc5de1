#include "coupling/bedload_dem/command_line.hpp"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <set>
#include <system_error>

#include "coupling/job/run_script.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/settings/nearest_name.hpp"

namespace bedload {
namespace {

// As LIGGGHTS reads them (lammps.cpp). -var takes a name and all words up to the next option.
const std::set<std::string> with_one_word{
    "-in",      "-i",  "-screen", "-sc", "-log",  "-l", "-echo",   "-e",  "-thermo", "-uid",
    "-pscreen", "-ps", "-plog",   "-pl", "-cuda", "-c", "-suffix", "-sf", "-domain"};
const std::set<std::string> with_two_words{"-reorder", "-ro"};
const std::set<std::string> alone{"-seedtolerant", "-st", "-wb", "-help", "-h"};
const std::set<std::string> in_parts{"-partition", "-p"};

bool is_option(const std::string& word) {
  return word.starts_with("-") && !is_negative_number(word);
}

void check_script(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    throw UserError(fmt::format("the script '{}' is not there", file));
  if (std::filesystem::is_directory(file, error))
    throw UserError(fmt::format("-in says '{}', which is a folder: -in in.liggghts", file));
  std::array<char, 3> begin{};
  std::ifstream(file).read(begin.data(), begin.size());
  if (begin == std::array<char, 3>{'\xef', '\xbb', '\xbf'})
    throw UserError(
        fmt::format("{}: begins with a byte order mark, which LIGGGHTS takes for a part "
                    "of the first word; save it as UTF-8 without one",
                    file));
}

[[noreturn]] void refuse_unknown(const std::string& word) {
  std::set<std::string> known{"-var"};
  for (const auto* const group : {&with_one_word, &with_two_words, &alone})
    known.insert(group->begin(), group->end());
  throw UserError(
      fmt::format("'{}' is no option; the nearest is '{}'", word, nearest(word, known)));
}

}  // namespace

void check_command_line(const std::vector<std::string>& words, bool coupled) {
  bool has_script = false;
  for (std::size_t n = 1; n < words.size(); ++n) {
    const std::string& option = words[n];
    const auto has_words = [&](std::size_t count) {
      for (std::size_t m = n + 1; m <= n + count; ++m)
        if (m >= words.size() || is_option(words[m])) return false;
      return true;
    };
    if (!is_option(option))
      throw UserError(
          n == 1 ? fmt::format("'{0}' is no option; the script is given by -in {0}", option)
                 : fmt::format("'{}' stands behind no option", option));
    if (option == "-in" || option == "-i") {
      if (!has_words(1)) throw UserError("-in says no script: -in in.liggghts");
      check_script(words[n + 1]);
      has_script = true;
    }
    if (option == "-var" || option == "-v") {
      if (!has_words(2))
        throw UserError(fmt::format("'{}' needs a name and a value: -var model actm", option));
      while (has_words(1)) ++n;
    } else if (in_parts.contains(option)) {
      if (coupled)
        throw UserError(
            fmt::format("'{}' divides LIGGGHTS into several, and a fluid has one; leave "
                        "it out",
                        option));
      while (has_words(1)) ++n;
    } else if (with_one_word.contains(option) || with_two_words.contains(option)) {
      const std::size_t count = with_one_word.contains(option) ? 1 : 2;
      if (!has_words(count))
        throw UserError(
            fmt::format("'{}' needs {} behind it", option, count == 1 ? "a word" : "two words"));
      n += count;
    } else if (!alone.contains(option)) {
      refuse_unknown(option);
    }
  }
  if (coupled && !has_script)
    throw UserError(
        "the command line names no script, and the fluid waits for one: -in in.liggghts");
}

}  // namespace bedload
