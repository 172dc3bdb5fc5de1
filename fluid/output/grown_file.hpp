#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "fluid/errors.hpp"
#include "fluid/output/aside_file.hpp"

namespace bedload {

/// Has `resume` go on with the file at `path` that an earlier part of the run has left. Returns
/// false when there is none, or when it was torn because the run was killed while it added to it:
/// it is moved out of the way then, which is said on stderr, and the caller begins a new one.
template <class Resume>
bool go_on(const std::string& path, Resume&& resume) {
  if (!find_grown(path)) return false;
  try {
    resume();
    return true;
  } catch (const UserError& error) {
    find_grown(path);
    const std::string torn = put_away(path);
    fmt::print(stderr,
               "bedload-fluid: {} The run before was ended while it wrote there; what is left is "
               "{}, and a new file begins.\n",
               error.what(), torn);
    return false;
  }
}

}  // namespace bedload
