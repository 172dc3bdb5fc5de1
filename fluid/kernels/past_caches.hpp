#pragma once

#include <cstddef>
#include <cstring>

namespace bedload {

/// An array of more than so many bytes has left the third-level cache when the sweep that reads it
/// comes, if the whole flow is as much larger as it is here. What is written to it may go past the
/// caches: an ordinary store first reads the line that it changes.
inline constexpr std::size_t cached_bytes = std::size_t{8} << 20;

/// A whole aligned register to memory that nothing reads for long. Where the compiler has no such
/// store, an ordinary one.
template <class Real, class Vector>
[[gnu::always_inline]] inline void store_past_caches(Real* to, const Vector& values) {
#if __has_builtin(__builtin_nontemporal_store)
  __builtin_nontemporal_store(values, reinterpret_cast<Vector*>(to));
#else
  std::memcpy(to, &values, sizeof(values));
#endif
}

}  // namespace bedload
