#pragma once

#include <cstdio>
#include <set>
#include <string>

namespace LAMMPS_NS {
class Input;
}

namespace bedload {

/// A stream for LIGGGHTS' screen in a coupled job: lines that report an error, or once a warning or
/// a note, go to stderr under the program's name, all others are dropped (LIGGGHTS' log has them),
/// so that the terminal belongs to the fluid's progress.
class LiggghtsScreen {
 public:
  LiggghtsScreen();
  ~LiggghtsScreen();
  LiggghtsScreen(const LiggghtsScreen&) = delete;
  LiggghtsScreen& operator=(const LiggghtsScreen&) = delete;

  FILE* stream() const { return stream_; }
  /// Errors name the line that this reader of a script is at; it has to outlive the last of them.
  void follow(const LAMMPS_NS::Input* input) { input_ = input; }
  /// Whether an error was reported.
  bool saw_error() const { return saw_error_; }

 private:
  void take(const char* text, std::size_t size);
  /// A sentence with the script's present line; "" where it says nothing.
  std::string place() const;

  FILE* stream_;
  const LAMMPS_NS::Input* input_ = nullptr;
  std::string line_;
  /// Warnings and notes so far: pairs and walls, and each coupled run, have the same to say.
  std::set<std::string> said_;
  bool saw_error_ = false;
};

}  // namespace bedload
