#pragma once

#include <optional>
#include <string>

namespace bedload {

/// "FILE: cannot be written (No space left on device)" for the first file of this rank that could
/// not be written to its end: dumps (those of VTK, too), logs, tables and restarts of LIGGGHTS,
/// which itself does not look. Nothing: all were written.
std::optional<std::string> unwritten_file();

}  // namespace bedload
