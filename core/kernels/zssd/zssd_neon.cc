#include "core/kernels/neon.h"
#include "core/kernels/zssd/zssd.h"

namespace pirvs {
namespace {

// A lane of sum adds at most 32 differences of 255 (16 x 16), so int16; squares at most
// 256 * 255^2 < 2^24.
struct Sums {
  int16x8_t sum = vdupq_n_s16(0);
  int32x4_t squares = vdupq_n_s32(0);

  void add(const uint8_t* a, const uint8_t* b) {
    const int16x8_t d = neon::subtract_bytes(a, b);
    sum = vaddq_s16(sum, d);
    squares = neon::add_products(squares, d, d);
  }

  // |sum| <= 256 * 255 = 65280, whose square still fits u32.
  uint32_t finish(int shift) const {
    const int32_t total = neon::sum_lanes(neon::add_lanes(vdupq_n_s32(0), sum));
    const uint32_t magnitude = static_cast<uint32_t>(total < 0 ? -total : total);
    return static_cast<uint32_t>(neon::sum_lanes(squares)) - ((magnitude * magnitude) >> shift);
  }
};

}  // namespace

uint32_t zssd_8x8_neon(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b) {
  Sums sums;
  for (int y = 0; y < 8; ++y) sums.add(a + y * stride_a, b + y * stride_b);
  return sums.finish(6);
}

uint32_t zssd_16x16_neon(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b,
                         ptrdiff_t stride_b) {
  Sums sums;
  for (int y = 0; y < 16; ++y) {
    sums.add(a + y * stride_a, b + y * stride_b);
    sums.add(a + y * stride_a + 8, b + y * stride_b + 8);
  }
  return sums.finish(8);
}

}  // namespace pirvs
