#pragma once

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace bedload {

/// From here on this thread's results too small for a normal number (1e-38 in single precision) are
/// zero. The elimination of a flow that is still at rest somewhere fades through such numbers, with
/// which the processor is slower by far.
inline void flush_subnormals() {
#ifdef __SSE__
  constexpr unsigned results_to_zero = 0x8000, operands_to_zero = 0x0040;
  _mm_setcsr(_mm_getcsr() | results_to_zero | operands_to_zero);
#endif
}

}  // namespace bedload
