// How different two patches are, whatever their brightness: zero-mean sum of squared differences,
// sum d^2 - (sum d)^2 / n, rounded up to an integer, with d = a - b over n = 8 x 8 or 16 x 16
// bytes.
// In      a, b: first pixels; strides in bytes, any sign. No alignment needed. Reads just the
//         patch.
// Out     grey^2, summed over the patch: 0..n * 16256.25.
// Errors  None.
// Cost    x86-64: 8 x 8: 6 ns, 16 x 16: 19 ns (make bench K=zssd).
// Goal    A72 cycles: zssd_8x8 90 a call, zssd_16x16 180 a call (make bench BOARD=qemu-virt).
// Source  Expansion of sum (d - mean d)^2.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs {

uint32_t zssd_8x8_ref(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b);
uint32_t zssd_8x8_neon(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b);
uint32_t zssd_16x16_ref(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b);
uint32_t zssd_16x16_neon(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b,
                         ptrdiff_t stride_b);

inline uint32_t zssd_8x8(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b,
                         ptrdiff_t stride_b) {
  return zssd_8x8_neon(a, stride_a, b, stride_b);
}
inline uint32_t zssd_16x16(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b,
                           ptrdiff_t stride_b) {
  return zssd_16x16_neon(a, stride_a, b, stride_b);
}

}  // namespace pirvs
