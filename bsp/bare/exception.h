// What vectors.S saves when an exception takes the core away from the code.
// In, Out the registers of the interrupted code.
// Errors  none.
// Cost    ~120 instructions in and out.
// Source  Arm ARM D1.10; the order is that of vectors.S.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::bsp {

struct ExceptionFrame {
  uint64_t x[31];
  uint64_t pc;        // ELR_EL1
  uint64_t state;     // SPSR_EL1
  uint64_t sp;        // SP_EL0, where the code's stack was
  uint64_t syndrome;  // ESR_EL1
  uint64_t address;   // FAR_EL1
  uint64_t fpcr;
  uint64_t fpsr;
  uint64_t q[32][2];
};
static_assert(offsetof(ExceptionFrame, pc) == 248 && offsetof(ExceptionFrame, q) == 304);
static_assert(sizeof(ExceptionFrame) == 816, "FRAME_BYTES of vectors.S");

enum class ExceptionKind : uint64_t { kSynchronous, kInterrupt, kFastInterrupt, kSystemError };
// The same four again when they strike a handler, and kOther for EL0, where nothing runs.
inline constexpr uint64_t kInHandler = 4;
inline constexpr uint64_t kOther = 8;

}  // namespace pirvs::bsp
