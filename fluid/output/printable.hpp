#pragma once

#include <string>

namespace bedload {

/// `text` for a terminal: control characters, which could command it (ESC, and the C1 controls of
/// UTF-8, 0xc2 0x80 to 0x9f), become '?'.
inline std::string printable(std::string text) {
  for (std::size_t n = 0; n < text.size(); ++n) {
    const auto byte = static_cast<unsigned char>(text[n]);
    if (byte < 0x20 || byte == 0x7f) {
      text[n] = '?';
    } else if (byte == 0xc2 && n + 1 < text.size() &&
               static_cast<unsigned char>(text[n + 1]) < 0xa0) {
      text.replace(n, 2, "?");
    }
  }
  return text;
}

}  // namespace bedload
