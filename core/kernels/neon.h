// NEON intrinsics on every machine: the real ones on AArch64, SIMDe's exact emulation elsewhere,
// and the few helpers where both need a different instruction for the same result.
// Errors  None. Integer helpers wrap; each caller proves that its sums fit.
// Source  Arm C Language Extensions, "Neon intrinsics"; SIMDe 0.7.4. That version lacks or breaks
//         vabal_u8, vcvtnq_s32_f32, vsliq_n and others: before using a new one, compare it with
//         the reference.
#pragma once

#if defined(__aarch64__)
#include <arm_neon.h>
#else
#define SIMDE_ENABLE_NATIVE_ALIASES  // NOLINT(readability-identifier-naming): SIMDe's name
#include <simde/arm/neon.h>
#endif

#include <cstdint>

namespace pirvs::neon {

#if defined(__SSE4_1__)
inline __m128i load_eight(const uint8_t* p) {
  return _mm_cvtepu8_epi16(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)));
}
#endif

// Eight bytes, widened. GCC 12 needs five instructions for SIMDe's vmovl_u8, here and below.
inline uint16x8_t load_widened(const uint8_t* p) {
#if defined(__SSE4_1__)
  return simde_uint16x8_from_m128i(load_eight(p));
#else
  return vmovl_u8(vld1_u8(p));
#endif
}

// a[i] - b[i] for eight bytes.
inline int16x8_t subtract_bytes(const uint8_t* a, const uint8_t* b) {
#if defined(__SSE4_1__)
  return simde_int16x8_from_m128i(_mm_sub_epi16(load_eight(a), load_eight(b)));
#else
  return vreinterpretq_s16_u16(vsubl_u8(vld1_u8(a), vld1_u8(b)));
#endif
}

// The low bytes of a, which must be below 256.
inline uint8x8_t narrow(uint16x8_t a) {
#if defined(__SSE2__)
  const __m128i wide = simde_uint16x8_to_m128i(a);
  return vget_low_u8(simde_uint8x16_from_m128i(_mm_packus_epi16(wide, wide)));
#else
  return vmovn_u16(a);
#endif
}

// a / 256, rounded to nearest, ties up. a + 128 must fit.
inline uint8x8_t narrow_rounded_256th(uint16x8_t a) {
#if defined(__SSE2__)
  return narrow(vshrq_n_u16(vaddq_u16(a, vdupq_n_u16(128)), 8));
#else
  return vrshrn_n_u16(a, 8);
#endif
}

// Sum of the lanes.
inline int32_t sum_lanes(int32x4_t a) {
#if defined(__SSE2__)
  const __m128i lanes = simde_int32x4_to_m128i(a);
  const __m128i pairs = _mm_add_epi32(lanes, _mm_shuffle_epi32(lanes, 0x4e));
  return _mm_cvtsi128_si32(_mm_add_epi32(pairs, _mm_shuffle_epi32(pairs, 0xb1)));
#else
  return vaddvq_s32(a);
#endif
}

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

// sums + a: the same as add_products with a factor of one, and on a Cortex-A72 in the other pipe.
inline int32x4_t add_lanes(int32x4_t sums, int16x8_t a) {
#if defined(__SSE2__)
  return add_products(sums, a, vdupq_n_s16(1));
#else
  return vpadalq_s16(sums, a);
#endif
}

// a * b - c * d, for lanes 0..3 and 4..7. c, d > -32768 and the difference must fit int32.
inline int32x4_t products_difference_low(int16x8_t a, int16x8_t b, int16x8_t c, int16x8_t d) {
#if defined(__SSE2__)
  const __m128i minus_d = _mm_sub_epi16(_mm_setzero_si128(), simde_int16x8_to_m128i(d));
  return simde_int32x4_from_m128i(
      _mm_madd_epi16(_mm_unpacklo_epi16(simde_int16x8_to_m128i(a), simde_int16x8_to_m128i(c)),
                     _mm_unpacklo_epi16(simde_int16x8_to_m128i(b), minus_d)));
#else
  return vmlsl_s16(vmull_s16(vget_low_s16(a), vget_low_s16(b)), vget_low_s16(c), vget_low_s16(d));
#endif
}
inline int32x4_t products_difference_high(int16x8_t a, int16x8_t b, int16x8_t c, int16x8_t d) {
#if defined(__SSE2__)
  const __m128i minus_d = _mm_sub_epi16(_mm_setzero_si128(), simde_int16x8_to_m128i(d));
  return simde_int32x4_from_m128i(
      _mm_madd_epi16(_mm_unpackhi_epi16(simde_int16x8_to_m128i(a), simde_int16x8_to_m128i(c)),
                     _mm_unpackhi_epi16(simde_int16x8_to_m128i(b), minus_d)));
#else
  return vmlsl_high_s16(vmull_high_s16(a, b), c, d);
#endif
}

// True if any bit is set.
inline bool any(uint32x4_t mask) {
#if defined(__SSE4_1__)
  const __m128i bits = simde_uint32x4_to_m128i(mask);
  return _mm_testz_si128(bits, bits) == 0;
#else
  return vmaxvq_u32(mask) != 0;
#endif
}

}  // namespace pirvs::neon
