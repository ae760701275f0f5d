#include <cstddef>

#include "core/base/assert.h"
#include "core/kernels/grey/grey.h"
#include "core/kernels/neon.h"

namespace pirvs {
namespace {

constexpr int kLanes = 16;

}  // namespace

void grey_from_pairs_neon(const RawImage& in, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    int x = 0;
    // The last pixel's second byte need not be there: a block of 16 ends before it.
    for (; x + kLanes < in.width; x += kLanes) vst1q_u8(to + x, vld2q_u8(from + 2 * x).val[0]);
    for (; x < in.width; ++x) to[x] = from[2 * x];
  }
}

void grey_from_words_neon(const RawImage& in, int shift, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  PIRVS_ASSERT(shift >= 0 && shift <= 8);
  const int16x8_t right = vdupq_n_s16(static_cast<int16_t>(-shift));
  const auto narrowed = [right](const uint8_t* at) {
    const uint16x8_t words = vreinterpretq_u16_u8(vld1q_u8(at));
    return vqmovn_u16(vshlq_u16(words, right));
  };
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    int x = 0;
    for (; x + kLanes <= in.width; x += kLanes) {
      vst1q_u8(to + x, vcombine_u8(narrowed(from + 2 * x), narrowed(from + 2 * x + kLanes)));
    }
    for (; x < in.width; ++x) {
      const int grey = (from[2 * x] | from[2 * x + 1] << 8) >> shift;
      to[x] = static_cast<uint8_t>(grey < 255 ? grey : 255);
    }
  }
}

}  // namespace pirvs
