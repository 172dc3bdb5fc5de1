#include "coupling/quiet_screen.hpp"

#include <stdio.h>

#include <string_view>

#include "coupling/roles.hpp"
#include "coupling/survivors.hpp"

namespace bedload {

QuietScreen::QuietScreen() {
  cookie_io_functions_t functions{};
  functions.write = [](void* self, const char* text, std::size_t size) {
    static_cast<QuietScreen*>(self)->take(text, size);
    return static_cast<ssize_t>(size);
  };
  stream_ = fopencookie(this, "w", functions);
  // LIGGGHTS may end the process right after its message.
  setvbuf(stream_, nullptr, _IONBF, 0);
}

QuietScreen::~QuietScreen() { std::fclose(stream_); }

void QuietScreen::take(const char* text, std::size_t size) {
  for (const char c : std::string_view(text, size)) {
    if (c != '\n') {
      line_ += c;
      continue;
    }
    if (line_.starts_with("ERROR")) {
      saw_error_ = true;
      speak_for_all();
      std::fprintf(stderr, "\n%s: %s%s\n", program_name(Program::dem), line_.c_str(),
                   last_checkpoint_sentence().c_str());
    } else if (line_.starts_with("WARNING")) {
      std::fprintf(stderr, "\n%s: %s\n", program_name(Program::dem), line_.c_str());
    }
    line_.clear();
  }
}

}  // namespace bedload
