#pragma once

#include <string>
#include <utility>
#include <vector>

#include "fluid/checkpoint/group.hpp"

namespace bedload {

/// What a person gave LIGGGHTS for a run: the script and the variables of the command line. Goes
/// into each checkpoint, so that a run that goes on takes its own variables and says what differs.
struct RunScript {
  using Variable = std::pair<std::string, std::vector<std::string>>;  ///< name, values

  /// The script's commands, one a line, without comments and with one blank between words; files
  /// that it includes stand in place of the line.
  std::vector<std::string> lines;
  std::vector<Variable> variables;
  /// Files that fixes of the script begin anew (fix ave/..., print), as far as the command line and
  /// the script say their names; not in checkpoints.
  std::vector<std::string> tables;

  void save(const SaveGroup& group) const;
  void load(const LoadGroup& group);
};

/// Whether a word of a command line that begins with '-' is a value all the same.
bool is_negative_number(const std::string& word);

/// The script and variables of LIGGGHTS' command line (-in FILE, -var NAME VALUE...). A file that
/// cannot be read is left to LIGGGHTS to complain about.
RunScript read_run_script(const std::vector<std::string>& words);

/// One sentence for each variable of the command line that no line of the script uses (`out` and
/// `inputs`, which every run is given, aside), with the nearest name that the script declares. None
/// where the script goes on in files that cannot be told beforehand.
std::vector<std::string> unused_variables(const RunScript& script);

/// Words of a command line that give LIGGGHTS those variables of `before` that `now` does not set.
std::vector<std::string> missing_variables(const RunScript& before, const RunScript& now);

/// Moves `tables` that hold something to the first of NAME.part1.ENDING, NAME.part2.ENDING, ...
/// that is free, and returns a sentence for each: what a run has written stays when it goes on.
std::vector<std::string> keep_tables(const std::vector<std::string>& tables);

/// What differs between two runs, a sentence each; `out`, where a run writes, and `inputs`, where
/// its parts come from, may.
std::vector<std::string> differences(const RunScript& before, const RunScript& now);

}  // namespace bedload
