#pragma once

#include <cstdio>
#include <set>
#include <string>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// A stream for LIGGGHTS' screen that tells, with an error, where in the script it arose. In a
/// coupled job lines that report an error, or once a warning or a note, go to stderr under the
/// program's name, all others are dropped (LIGGGHTS' log has them), so that the terminal belongs to
/// the fluid's progress.
class LiggghtsScreen {
 public:
  /// @param all where everything goes as LIGGGHTS says it; nullptr in a coupled job
  explicit LiggghtsScreen(FILE* all);
  ~LiggghtsScreen();
  LiggghtsScreen(const LiggghtsScreen&) = delete;
  LiggghtsScreen& operator=(const LiggghtsScreen&) = delete;

  FILE* stream() const { return stream_; }
  /// Errors name the line of the script that this LIGGGHTS is at; it has to outlive the last of
  /// them.
  void follow(const LAMMPS_NS::LAMMPS* lmp) { lmp_ = lmp; }
  /// Whether an error was reported.
  bool saw_error() const { return saw_error_; }

 private:
  void take(const char* text, std::size_t size);
  /// Sentences with the script's present line, its place, and the nearest name where `error` is
  /// about an unknown one; "" where there is nothing to say.
  std::string place(const std::string& error) const;

  void take_line();

  FILE* all_;
  FILE* stream_;
  const LAMMPS_NS::LAMMPS* lmp_ = nullptr;
  std::string line_;
  std::string begun_;  ///< of a warning that goes on in the next line
  /// Warnings and notes so far: pairs and walls, and each coupled run, have the same to say.
  std::set<std::string> said_;
  bool saw_error_ = false;
};

}  // namespace bedload
