#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "fluid/files/atomic_file.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {

/// Has `resume` go on with the file at `path` that an earlier part of the run has left. Returns
/// false when there is none, or when it is damaged because the run was killed while it wrote to it:
/// it is moved out of the way then, which is said on stderr, and the caller begins a new one.
template <class Resume>
bool resume_or_set_aside(const std::string& path, Resume&& resume) {
  if (!find_resumable(path)) return false;
  try {
    resume();
    return true;
  } catch (const UserError& error) {
    find_resumable(path);
    const std::string kept = rename_damaged_file(path);
    fmt::print(stderr,
               "bedload-fluid: {} The run before was ended while it wrote there; what is left is "
               "{}, and a new file begins.\n",
               error.what(), kept);
    return false;
  }
}

}  // namespace bedload
