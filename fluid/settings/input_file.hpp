#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "fluid/settings/errors.hpp"

namespace bedload {

/// Opens a file that the user names. Throws UserError where it cannot be opened, and for what is no
/// ordinary file: a pipe or a device may never come to its end.
inline std::ifstream open_input(const std::string& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw UserError(
        fmt::format("{}: is a folder, a pipe or a device, but must be an ordinary file.", file));
  std::ifstream stream(file);
  if (!stream) throw UserError(fmt::format("{}: the file cannot be opened.", file));
  return stream;
}

}  // namespace bedload
