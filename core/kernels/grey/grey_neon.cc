#include <cstddef>
#include <cstring>

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

namespace {

// As many whole blocks as end before the row's last pixel, behind which no byte need be there; how
// many pixels those are.
int unpack_twelve(const uint8_t* from, int width, uint8_t* to) {
  int x = 0;
  for (; x + 2 * kLanes < width; x += 2 * kLanes) {
    const uint8x16x3_t bytes = vld3q_u8(from + x / 2 * 3);
    const uint8x16x2_t pixels = {{bytes.val[0], bytes.val[1]}};
    vst2q_u8(to + x, pixels);
  }
  return x;
}

int unpack_ten(const uint8_t* from, int width, uint8_t* to) {
  // Of 20 bytes, of which the second register begins with the fifth: 12 and more are at its 16.
  constexpr uint8_t kPlaces[kLanes] = {0, 1, 2, 3, 5, 6, 7, 8, 10, 11, 12, 13, 27, 28, 29, 30};
  const uint8x16_t places = vld1q_u8(kPlaces);
  int x = 0;
  for (; x + kLanes < width; x += kLanes) {
    const uint8_t* const at = from + x / 4 * 5;
    const uint8x16x2_t bytes = {{vld1q_u8(at), vld1q_u8(at + 4)}};
    vst1q_u8(to + x, vqtbl2q_u8(bytes, places));
  }
  return x;
}

}  // namespace

void grey_from_packed_neon(const RawImage& in, int group, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  PIRVS_ASSERT(group == 3 || group == 5);
  const int pixels = group - 1;
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    int x = group == 3 ? unpack_twelve(from, in.width, to) : unpack_ten(from, in.width, to);
    for (; x < in.width; ++x) to[x] = from[x / pixels * group + x % pixels];
  }
}

// In place a block is read with the pixel behind it before it is written, a row before the next.
void grey_from_bayer_neon(const RawImage& in, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 1 && in.height > 1 && out_stride >= in.width);
  for (int y = 0; y + 1 < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    const uint8_t* const below = from + in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    int x = 0;
    // Sums of four bytes: 1020 at most.
    for (; x + kLanes < in.width; x += kLanes) {
      const uint8x16_t a = vld1q_u8(from + x), b = vld1q_u8(from + x + 1);
      const uint8x16_t c = vld1q_u8(below + x), d = vld1q_u8(below + x + 1);
      const uint16x8_t low = vaddq_u16(vaddl_u8(vget_low_u8(a), vget_low_u8(b)),
                                       vaddl_u8(vget_low_u8(c), vget_low_u8(d)));
      const uint16x8_t high = vaddq_u16(vaddl_u8(vget_high_u8(a), vget_high_u8(b)),
                                        vaddl_u8(vget_high_u8(c), vget_high_u8(d)));
      vst1q_u8(to + x, vcombine_u8(vrshrn_n_u16(low, 2), vrshrn_n_u16(high, 2)));
    }
    for (; x + 1 < in.width; ++x) {
      const int sum = from[x] + from[x + 1] + below[x] + below[x + 1];
      to[x] = static_cast<uint8_t>((sum + 2) / 4);
    }
    to[in.width - 1] = to[in.width - 2];
  }
  uint8_t* const last = out + static_cast<ptrdiff_t>(in.height - 1) * out_stride;
  std::memcpy(last, last - out_stride, static_cast<size_t>(in.width));
}

void grey_from_rgb_neon(const RawImage& in, bool blue_first, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  const int red = blue_first ? 2 : 0;
  const uint8x8_t red_weight = vdup_n_u8(kRedWeight), green_weight = vdup_n_u8(kGreenWeight),
                  blue_weight = vdup_n_u8(kBlueWeight);
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    int x = 0;
    // 256 * 255 at most, and half of 256 to round: fits 16 bits.
    for (; x + kLanes <= in.width; x += kLanes) {
      const uint8x16x3_t pixels = vld3q_u8(from + 3 * x);
      const uint8x16_t r = blue_first ? pixels.val[2] : pixels.val[0];
      const uint8x16_t b = blue_first ? pixels.val[0] : pixels.val[2];
      uint16x8_t low = vmull_u8(vget_low_u8(r), red_weight);
      uint16x8_t high = vmull_u8(vget_high_u8(r), red_weight);
      low = vmlal_u8(low, vget_low_u8(pixels.val[1]), green_weight);
      high = vmlal_u8(high, vget_high_u8(pixels.val[1]), green_weight);
      low = vmlal_u8(low, vget_low_u8(b), blue_weight);
      high = vmlal_u8(high, vget_high_u8(b), blue_weight);
      vst1q_u8(to + x, vcombine_u8(vrshrn_n_u16(low, 8), vrshrn_n_u16(high, 8)));
    }
    for (; x < in.width; ++x) {
      const uint8_t* const pixel = from + 3 * x;
      const int sum =
          kRedWeight * pixel[red] + kGreenWeight * pixel[1] + kBlueWeight * pixel[2 - red];
      to[x] = static_cast<uint8_t>((sum + 128) >> 8);
    }
  }
}

void grey_from_limited_neon(const RawImage& in, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  constexpr int kHalf = 1 << (kVideoShift - 1);
  const uint8x16_t black = vdupq_n_u8(kVideoBlack);
  const uint8x8_t gain = vdup_n_u8(kVideoGain);
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    int x = 0;
    // 239 * 149 at most.
    for (; x + kLanes <= in.width; x += kLanes) {
      const uint8x16_t above = vqsubq_u8(vld1q_u8(from + x), black);
      const uint16x8_t low = vmull_u8(vget_low_u8(above), gain);
      const uint16x8_t high = vmull_u8(vget_high_u8(above), gain);
      vst1q_u8(to + x,
               vcombine_u8(vqrshrn_n_u16(low, kVideoShift), vqrshrn_n_u16(high, kVideoShift)));
    }
    for (; x < in.width; ++x) {
      const int above = from[x] > kVideoBlack ? from[x] - kVideoBlack : 0;
      const int grey = (above * kVideoGain + kHalf) >> kVideoShift;
      to[x] = static_cast<uint8_t>(grey < 255 ? grey : 255);
    }
  }
}

}  // namespace pirvs
