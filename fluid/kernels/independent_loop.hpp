#pragma once

/// Stands before an x loop whose iterations are independent of each other: whatever they write, no
/// other iteration reads. Unlike `restrict` pointers it does not invite the compiler to carry
/// row[i] over to the next iteration as its row[i-1], which would make the loop sequential again.
#if defined(__clang__)
#define BEDLOAD_INDEPENDENT_LOOP _Pragma("clang loop vectorize(assume_safety)")
#else
#define BEDLOAD_INDEPENDENT_LOOP _Pragma("GCC ivdep")
#endif
