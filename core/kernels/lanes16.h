// Sixteen int16 lanes, the width of a patch row: one register with AVX2, two on NEON (and on x86
// without AVX2, through SIMDe). The same integers everywhere.
// Errors  None. Results wrap; each caller proves that they fit.
// Source  Why it exists: SIMDe maps NEON to 128 bits, which left lk a third slower on x86.
#pragma once

#include <cstdint>

#include "core/kernels/neon.h"

namespace pirvs::neon {

#if defined(__AVX2__)

using Int16x16 = __m256i;

inline Int16x16 fill(int16_t v) { return _mm256_set1_epi16(v); }
inline Int16x16 load(const int16_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}
inline Int16x16 load_bytes(const uint8_t* p) {
  return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
}
inline void store(int16_t* p, Int16x16 a) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a); }
inline Int16x16 add(Int16x16 a, Int16x16 b) { return _mm256_add_epi16(a, b); }
inline Int16x16 subtract(Int16x16 a, Int16x16 b) { return _mm256_sub_epi16(a, b); }
inline Int16x16 absolute(Int16x16 a) { return _mm256_abs_epi16(a); }
inline Int16x16 smaller(Int16x16 a, Int16x16 b) { return _mm256_min_epi16(a, b); }
inline Int16x16 larger(Int16x16 a, Int16x16 b) { return _mm256_max_epi16(a, b); }
inline Int16x16 multiply(Int16x16 a, Int16x16 b) { return _mm256_mullo_epi16(a, b); }
// a / 2^kBits, rounded to nearest, ties up. a + 2^(kBits - 1) must fit.
template <int kBits>
Int16x16 shift_right_rounded(Int16x16 a) {
  return _mm256_srai_epi16(add(a, fill(1 << (kBits - 1))), kBits);
}

// (2 a b + 2^15) >> 16, for a and b not both -32768.
inline Int16x16 multiply_q15(Int16x16 a, Int16x16 b) { return _mm256_mulhrs_epi16(a, b); }

// a[i] * weight_a + b[i] * weight_b for sixteen bytes. Weights 0..255, the same in all lanes.
inline Int16x16 blend_bytes(const uint8_t* a, Int16x16 weight_a, const uint8_t* b,
                            Int16x16 weight_b) {
  return add(_mm256_mullo_epi16(load_bytes(a), weight_a),
             _mm256_mullo_epi16(load_bytes(b), weight_b));
}

// A sum of products of int16 lanes. Exact if no part of the sum can leave int32.
class ProductSum {
 public:
  void add_products(Int16x16 a, Int16x16 b) {
    sums_ = _mm256_add_epi32(sums_, _mm256_madd_epi16(a, b));
  }
  void add(Int16x16 a) { add_products(a, fill(1)); }
  int32_t total() const {
    return sum_lanes(simde_int32x4_from_m128i(
        _mm_add_epi32(_mm256_castsi256_si128(sums_), _mm256_extracti128_si256(sums_, 1))));
  }

 private:
  __m256i sums_ = _mm256_setzero_si256();
};

#else

struct Int16x16 {
  int16x8_t low, high;
};

inline Int16x16 fill(int16_t v) { return {vdupq_n_s16(v), vdupq_n_s16(v)}; }
inline Int16x16 load(const int16_t* p) { return {vld1q_s16(p), vld1q_s16(p + 8)}; }
inline void store(int16_t* p, Int16x16 a) {
  vst1q_s16(p, a.low);
  vst1q_s16(p + 8, a.high);
}
inline Int16x16 add(Int16x16 a, Int16x16 b) {
  return {vaddq_s16(a.low, b.low), vaddq_s16(a.high, b.high)};
}
inline Int16x16 subtract(Int16x16 a, Int16x16 b) {
  return {vsubq_s16(a.low, b.low), vsubq_s16(a.high, b.high)};
}
inline Int16x16 absolute(Int16x16 a) { return {vabsq_s16(a.low), vabsq_s16(a.high)}; }
inline Int16x16 smaller(Int16x16 a, Int16x16 b) {
  return {vminq_s16(a.low, b.low), vminq_s16(a.high, b.high)};
}
inline Int16x16 larger(Int16x16 a, Int16x16 b) {
  return {vmaxq_s16(a.low, b.low), vmaxq_s16(a.high, b.high)};
}
inline Int16x16 multiply(Int16x16 a, Int16x16 b) {
  return {vmulq_s16(a.low, b.low), vmulq_s16(a.high, b.high)};
}
template <int kBits>
Int16x16 shift_right_rounded(Int16x16 a) {
#if defined(__aarch64__)
  return {vrshrq_n_s16(a.low, kBits), vrshrq_n_s16(a.high, kBits)};
#else
  const Int16x16 sum = add(a, fill(1 << (kBits - 1)));
  return {vshrq_n_s16(sum.low, kBits), vshrq_n_s16(sum.high, kBits)};
#endif
}
inline Int16x16 multiply_q15(Int16x16 a, Int16x16 b) {
  return {vqrdmulhq_s16(a.low, b.low), vqrdmulhq_s16(a.high, b.high)};
}
inline Int16x16 blend_bytes(const uint8_t* a, Int16x16 weight_a, const uint8_t* b,
                            Int16x16 weight_b) {
  const uint8x16_t bytes_a = vld1q_u8(a), bytes_b = vld1q_u8(b);
  const uint8x16_t wa = vreinterpretq_u8_s16(weight_a.low), wb = vreinterpretq_u8_s16(weight_b.low);
  const uint8x16_t all_a = vdupq_laneq_u8(wa, 0), all_b = vdupq_laneq_u8(wb, 0);
  const uint16x8_t low = vmlal_u8(vmull_u8(vget_low_u8(bytes_a), vget_low_u8(all_a)),
                                  vget_low_u8(bytes_b), vget_low_u8(all_b));
  const uint16x8_t high = vmlal_high_u8(vmull_high_u8(bytes_a, all_a), bytes_b, all_b);
  return {vreinterpretq_s16_u16(low), vreinterpretq_s16_u16(high)};
}

class ProductSum {
 public:
  void add_products(Int16x16 a, Int16x16 b) {
    sums_ = neon::add_products(neon::add_products(sums_, a.low, b.low), a.high, b.high);
  }
  void add(Int16x16 a) { sums_ = add_lanes(add_lanes(sums_, a.low), a.high); }
  int32_t total() const { return sum_lanes(sums_); }

 private:
  int32x4_t sums_ = vdupq_n_s32(0);
};

#endif

}  // namespace pirvs::neon
