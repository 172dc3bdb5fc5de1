#pragma once

#include <cstdio>
#include <string>

namespace bedload {

/// A stream for LIGGGHTS' screen in a coupled job: lines that report an error or a warning go to
/// stderr under the program's name, all others are dropped (LIGGGHTS' log has them), so that the
/// terminal belongs to the fluid's progress.
class QuietScreen {
 public:
  QuietScreen();
  ~QuietScreen();
  QuietScreen(const QuietScreen&) = delete;
  QuietScreen& operator=(const QuietScreen&) = delete;

  FILE* stream() const { return stream_; }
  /// Whether an error was reported.
  bool saw_error() const { return saw_error_; }

 private:
  void take(const char* text, std::size_t size);

  FILE* stream_;
  std::string line_;
  bool saw_error_ = false;
};

}  // namespace bedload
