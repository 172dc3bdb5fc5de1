#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>

namespace bedload {

/// Asks the system to hold `bytes` of untouched memory in large pages (2 MB), as far as whole ones
/// fit: a sweep over many rows needs few translations then. A wish; nothing else depends on it.
inline void ask_for_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t page = std::uintptr_t{2} << 20;
  const std::uintptr_t begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (begin + page - 1) / page * page,
                       end = (begin + bytes) / page * page;
  if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
#endif
}

}  // namespace bedload
