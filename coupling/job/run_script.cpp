#include "coupling/job/run_script.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "fluid/settings/nearest_name.hpp"

namespace bedload {
namespace {

constexpr std::size_t most_told = 20;
constexpr int deepest_include = 10;
constexpr char between_values = '\x1f';  // in a checkpoint; a value may have blanks

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line.substr(0, line.find('#')));
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// `text` with ${name} replaced where the value is known.
std::string substituted(std::string text, const std::map<std::string, std::string>& values) {
  for (std::size_t at = 0; (at = text.find("${", at)) != std::string::npos;) {
    const std::size_t end = text.find('}', at);
    if (end == std::string::npos) break;
    const auto known = values.find(text.substr(at + 2, end - at - 2));
    if (known == values.end())
      at = end;
    else
      text.replace(at, end - at + 1, known->second);
  }
  return text;
}

/// The file that a line of the script begins anew, as a fix that averages or prints does; else
/// none.
std::string table_of(const std::vector<std::string>& words,
                     const std::map<std::string, std::string>& values) {
  if (words.size() < 4 || words[0] != "fix") return {};
  const std::string style = substituted(words[3], values);
  if (style != "print" && !style.starts_with("ave/")) return {};
  const auto key = std::find(words.begin() + 4, words.end(), "file");
  if (key == words.end() || key + 1 == words.end()) return {};
  const std::string file = substituted(key[1], values);
  return file.find('$') == std::string::npos ? file : std::string{};
}

/// Appends the commands of a file; false: it cannot be read.
bool append_file(const std::string& file, int depth, std::map<std::string, std::string>& values,
                 RunScript& script) {
  std::ifstream stream(file);
  if (!stream || depth > deepest_include) return false;
  std::string command;
  for (std::string line; std::getline(stream, line);) {
    command += line;
    if (const auto last = command.find_last_not_of(" \t\r");
        last != std::string::npos && command[last] == '&') {  // goes on in the next line
      command.resize(last);
      command += ' ';
      continue;
    }
    const std::vector<std::string> words = words_of(std::exchange(command, ""));
    if (words.empty()) continue;
    // A variable that is set already keeps its value, as LIGGGHTS has it for this style.
    if (words.size() > 3 && words[0] == "variable" && words[2] == "index")
      values.try_emplace(words[1], substituted(words[3], values));
    if (words.size() > 3 && words[0] == "variable" && words[2] == "string")
      values[words[1]] = substituted(words[3], values);
    if (words.size() == 2 && words[0] == "include" &&
        append_file(substituted(words[1], values), depth + 1, values, script))
      continue;
    if (std::string table = table_of(words, values); !table.empty())
      script.tables.push_back(std::move(table));
    script.lines.push_back(fmt::format("{}", fmt::join(words, " ")));
  }
  return true;
}

const std::vector<std::string>* values_of(const RunScript& script, const std::string& name) {
  for (const auto& [known, values] : script.variables)
    if (known == name) return &values;
  return nullptr;
}

/// Lines of `a` that `b` does not have as often.
std::vector<std::string> only_in(const std::vector<std::string>& a,
                                 const std::vector<std::string>& b) {
  std::map<std::string, int> left;
  for (const std::string& line : b) ++left[line];
  std::vector<std::string> only;
  for (const std::string& line : a)
    if (--left[line] < 0) only.push_back(line);
  return only;
}

}  // namespace

void RunScript::save(const SaveGroup& group) const {
  group.text("script", fmt::format("{}", fmt::join(lines, "\n")));
  std::string text;
  for (const auto& [name, values] : variables)
    text += fmt::format("{} {}\n", name, fmt::join(values, std::string(1, between_values)));
  group.text("variables", text);
}

void RunScript::load(const LoadGroup& group) {
  std::istringstream script(group.text("script")), texts(group.text("variables"));
  for (std::string line; std::getline(script, line);) lines.push_back(line);
  for (std::string line; std::getline(texts, line);) {
    const std::size_t blank = line.find(' ');
    std::istringstream rest(line.substr(blank + 1));
    auto& values = variables.emplace_back(line.substr(0, blank), std::vector<std::string>{}).second;
    for (std::string value; std::getline(rest, value, between_values);) values.push_back(value);
  }
}

bool is_negative_number(const std::string& word) {
  return word.size() > 1 && word[0] == '-' &&
         (word[1] == '.' || (word[1] >= '0' && word[1] <= '9'));
}

RunScript read_run_script(const std::vector<std::string>& words) {
  RunScript script;
  std::string file;
  for (std::size_t n = 1; n < words.size(); ++n) {
    if ((words[n] == "-in" || words[n] == "-i") && n + 1 < words.size()) file = words[++n];
    if (words[n] != "-var" && words[n] != "-v") continue;
    if (n + 1 >= words.size()) break;
    const std::string& name = words[++n];
    std::vector<std::string> values;
    while (n + 1 < words.size() && (words[n + 1][0] != '-' || is_negative_number(words[n + 1])))
      values.push_back(words[++n]);
    if (!values_of(script, name)) script.variables.emplace_back(name, values);
  }
  std::map<std::string, std::string> values;
  for (const auto& [name, given] : script.variables)
    values.emplace(name, given.empty() ? "" : given.front());
  append_file(file, 0, values, script);
  return script;
}

std::vector<std::string> unused_variables(const RunScript& script) {
  std::set<std::string> declared;
  for (const std::string& line : script.lines) {
    const std::vector<std::string> words = words_of(line);
    if (words[0] == "include" || words[0] == "jump") return {};
    if (words[0] == "variable" && words.size() > 1) declared.insert(words[1]);
  }
  const auto is_used = [&](const std::string& name) {
    if (declared.contains(name) || name == "out" || name == "inputs") return true;
    std::vector<std::string> uses{"${" + name + "}", "v_" + name};
    if (name.size() == 1) uses.push_back("$" + name);
    return std::any_of(script.lines.begin(), script.lines.end(), [&](const std::string& line) {
      return std::any_of(uses.begin(), uses.end(), [&](const std::string& use) {
        return line.find(use) != std::string::npos;
      });
    });
  };
  std::vector<std::string> sentences;
  for (const auto& [name, values] : script.variables) {
    if (is_used(name)) continue;
    const std::string near = nearest(name, declared);
    sentences.push_back(fmt::format(
        "no line of the script uses the variable '{}' that the command line sets{}", name,
        near.empty() ? "" : fmt::format("; the nearest that it declares is '{}'", near)));
  }
  return sentences;
}

std::vector<std::string> missing_variables(const RunScript& before, const RunScript& now) {
  std::vector<std::string> words;
  for (const auto& [name, values] : before.variables) {
    if (values_of(now, name)) continue;
    words.insert(words.end(), {"-var", name});
    words.insert(words.end(), values.begin(), values.end());
  }
  return words;
}

std::vector<std::string> keep_tables(const std::vector<std::string>& tables) {
  namespace fs = std::filesystem;
  std::vector<std::string> sentences;
  for (const fs::path table : tables) {
    std::error_code error;
    if (!fs::is_regular_file(table, error) || fs::file_size(table, error) == 0) continue;
    fs::path kept;
    for (int part = 1; kept.empty() || fs::exists(kept, error); ++part)
      kept = fs::path(table).replace_extension(
          fmt::format(".part{}{}", part, table.extension().string()));
    fs::rename(table, kept, error);
    sentences.push_back(error ? fmt::format("{} could not be kept ({}) and begins anew",
                                            table.string(), error.message())
                              : fmt::format("{} begins anew; what it held is {} now",
                                            table.string(), kept.string()));
  }
  return sentences;
}

std::vector<std::string> differences(const RunScript& before, const RunScript& now) {
  std::vector<std::string> sentences;
  for (const auto& [name, values] : now.variables) {
    const auto* const old = values_of(before, name);
    if (name == "out" || name == "inputs" || (old && *old == values)) continue;
    sentences.push_back(fmt::format(
        "the variable '{}' is {}, in the run before {}", name, fmt::join(values, " "),
        old ? fmt::format("{}", fmt::join(*old, " ")) : "it was not set on the command line"));
  }
  const auto more = only_in(now.lines, before.lines), gone = only_in(before.lines, now.lines);
  for (const std::string& line : gone)
    sentences.push_back(fmt::format("the script has no more '{}'", line));
  for (const std::string& line : more)
    sentences.push_back(fmt::format("the script has '{}', which the run before had not", line));
  if (more.empty() && gone.empty() && now.lines != before.lines)
    sentences.push_back("the script has its lines in another order");
  if (sentences.size() > most_told) {
    const std::size_t rest = sentences.size() - most_told;
    sentences.resize(most_told);
    sentences.push_back(fmt::format("and {} more differences of the script", rest));
  }
  return sentences;
}

}  // namespace bedload
