#pragma once

#include <cstdint>

namespace bedload {

/// FNV-1a over words of 64 bits in place of bytes (Fowler, Noll, Vo): a fingerprint that differs
/// when one of the words or their order does. Start from fnv_start, then mix in word by word.
constexpr std::uint64_t fnv_start = 14695981039346656037ULL;

constexpr std::uint64_t fnv_mixed(std::uint64_t hash, std::uint64_t word) {
  return (hash ^ word) * 1099511628211ULL;
}

}  // namespace bedload
