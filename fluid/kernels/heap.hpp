#pragma once

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

namespace bedload {

/// Lets the C library keep small memory that is freed, instead of giving it back to the system to
/// ask for it again a moment later, page by page: FFTW takes a buffer anew for each execution of
/// some plans, and a plane's transforms took three times as long where that buffer happened to lie
/// at the end of the heap (192 x 192 cells, single precision; ./bedload bench fluid). Fields, all
/// above 4 MB, still go back when they are freed.
inline void keep_freed_buffers() {
#if defined(M_TRIM_THRESHOLD) && defined(M_MMAP_THRESHOLD)
  mallopt(M_MMAP_THRESHOLD, 4 << 20);
  mallopt(M_TRIM_THRESHOLD, 32 << 20);
#endif
}

}  // namespace bedload
