#include "core/kernels/neon.h"
#include "core/kernels/pyramid/pyramid.h"
#include "core/kernels/pyramid/pyramid_border.h"

namespace pirvs {
namespace {

using pyramid_detail::mirror;

// 1 4 6 4 1. At most 16 * 255 horizontally and 256 * 255 = 65280 in both directions, and 128 more
// for rounding still fits u16.
inline uint16x8_t binomial(uint16x8_t a, uint16x8_t b, uint16x8_t c, uint16x8_t d, uint16x8_t e) {
  const uint16x8_t inner = vaddq_u16(vaddq_u16(b, d), c);
  return vaddq_u16(vaddq_u16(a, e), vaddq_u16(vshlq_n_u16(inner, 2), vaddq_u16(c, c)));
}

inline uint16_t blend_one(const uint8_t* in, int width, int x) {
  const int sum = in[mirror(2 * x - 2, width)] + 4 * in[mirror(2 * x - 1, width)] + 6 * in[2 * x] +
                  4 * in[mirror(2 * x + 1, width)] + in[mirror(2 * x + 2, width)];
  return static_cast<uint16_t>(sum);
}

// Eight outputs from 2 x on. A little-endian pair of bytes is one u16: its low byte is the even
// pixel and its high byte the odd one. Reads in[2 x - 2 .. 2 x + 17].
inline uint16x8_t blend_eight(const uint8_t* in, int x) {
  const uint16x8_t low = vdupq_n_u16(255);
  const uint16x8_t before = vreinterpretq_u16_u8(vld1q_u8(in + 2 * x - 2));
  const uint16x8_t here = vreinterpretq_u16_u8(vld1q_u8(in + 2 * x));
  const uint16x8_t after = vreinterpretq_u16_u8(vld1q_u8(in + 2 * x + 2));
  return binomial(vandq_u16(before, low), vshrq_n_u16(before, 8), vandq_u16(here, low),
                  vshrq_n_u16(here, 8), vandq_u16(after, low));
}

// The horizontal pass on one row: (width + 1) / 2 sums. The last eight start where their 20 bytes
// just fit and repeat some.
void blend_row(const uint8_t* in, int width, uint16_t* out) {
  const int count = (width + 1) / 2;
  out[0] = blend_one(in, width, 0);
  int x = 1;
  const int last = (width - 18) / 2;
  if (width >= 20) {
    for (; x < last; x += 8) vst1q_u16(out + x, blend_eight(in, x));
    vst1q_u16(out + last, blend_eight(in, last));
    x = last + 8;
  }
  for (; x < count; ++x) out[x] = blend_one(in, width, x);
}

// The vertical pass: rounds and narrows.
void blend_rows(const uint16_t* const (&rows)[5], int count, uint8_t* out) {
  const auto at = [&](int x) {
    const uint16x8_t sum =
        binomial(vld1q_u16(rows[0] + x), vld1q_u16(rows[1] + x), vld1q_u16(rows[2] + x),
                 vld1q_u16(rows[3] + x), vld1q_u16(rows[4] + x));
    return neon::narrow_rounded_256th(sum);
  };
  int x = 0;
  for (; x + 8 <= count; x += 8) vst1_u8(out + x, at(x));
  if (x < count && count >= 8) {
    vst1_u8(out + count - 8, at(count - 8));
    return;
  }
  for (; x < count; ++x) {
    const int sum = rows[0][x] + rows[4][x] + 4 * (rows[1][x] + rows[3][x]) + 6 * rows[2][x];
    out[x] = static_cast<uint8_t>((sum + 128) >> 8);
  }
}

}  // namespace

void pyramid_down_neon(const ImageView& in, uint8_t* out, int out_stride) {
  pyramid_detail::check(in, out_stride);
  const int width = (in.width + 1) / 2, height = (in.height + 1) / 2;
  // Horizontal sums of input row r stay in slot r % 5 until five more rows have come: mirrored rows
  // are among the last five as well.
  alignas(16) uint16_t sums[5][kPyramidWidthMax / 2];
  int ready = 0;
  for (int y = 0; y < height; ++y) {
    for (; ready < in.height && ready <= 2 * y + 2; ++ready)
      blend_row(in.row(ready), in.width, sums[ready % 5]);
    const uint16_t* rows[5];
    for (int j = 0; j < 5; ++j) rows[j] = sums[mirror(2 * y + j - 2, in.height) % 5];
    blend_rows(rows, width, out + static_cast<int64_t>(y) * out_stride);
  }
}

}  // namespace pirvs
