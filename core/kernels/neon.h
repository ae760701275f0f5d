// NEON intrinsics on every machine: the real ones on AArch64, SIMDe's exact emulation elsewhere,
// and the few helpers where both need a different instruction for the same result.
// Errors  None. Integer helpers wrap; each caller proves that its sums fit.
// Source  Arm C Language Extensions, "Neon intrinsics"; SIMDe 0.7.4, which lacks or breaks
// vabal_u8,
//         vcvtnq_s32_f32, vsliq_n and others: compare with the reference before using a new one.
#pragma once

#if defined(__aarch64__)
#include <arm_neon.h>
#else
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/arm/neon.h>
#endif

#include <cstdint>

namespace pirvs::neon {

// sums + a * b. Which lane of the sum a product goes to differs between machines; only the sum of
// all four lanes is defined, and exact as long as no partial sum leaves int32.
inline int32x4_t add_products(int32x4_t sums, int16x8_t a, int16x8_t b) {
#if defined(__SSE2__)
  return vreinterpretq_s32_s16(simde_int16x8_from_m128i(
      _mm_add_epi32(simde_int32x4_to_m128i(sums),
                    _mm_madd_epi16(simde_int16x8_to_m128i(a), simde_int16x8_to_m128i(b)))));
#else
  return vmlal_high_s16(vmlal_s16(sums, vget_low_s16(a), vget_low_s16(b)), a, b);
#endif
}

// The low and high eight bytes of a, widened to 16 bits.
inline uint16x8_t widen_low(uint8x16_t a) { return vmovl_u8(vget_low_u8(a)); }
inline uint16x8_t widen_high(uint8x16_t a) { return vmovl_high_u8(a); }

}  // namespace pirvs::neon
