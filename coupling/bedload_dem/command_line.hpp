#pragma once

#include <string>
#include <vector>

namespace bedload {

/// Mistakes of bedload-dem's command line that LIGGGHTS answers without naming the word, or before
/// its screen can be read. Throws UserError.
/// @param words the program's name and what stands behind it
/// @param coupled whether a fluid waits for the script
void check_command_line(const std::vector<std::string>& words, bool coupled);

}  // namespace bedload
