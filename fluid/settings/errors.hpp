#pragma once

#include <stdexcept>
#include <string>

namespace bedload {

/// A mistake of the user (input, files, contradictory settings): one sentence with file, key, the
/// value found and what is allowed. Program bugs are assertions, not this.
class UserError : public std::runtime_error {
 public:
  explicit UserError(const std::string& sentence) : std::runtime_error(sentence) {}
};

}  // namespace bedload
