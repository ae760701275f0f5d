#include <algorithm>
#include <cstddef>

#include "core/base/assert.h"
#include "core/kernels/grey/grey.h"

namespace pirvs {

void grey_from_pairs_ref(const RawImage& in, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    for (int x = 0; x < in.width; ++x) to[x] = from[2 * x];
  }
}

void grey_from_words_ref(const RawImage& in, int shift, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  PIRVS_ASSERT(shift >= 0 && shift <= 8);
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    for (int x = 0; x < in.width; ++x) {
      const int word = from[2 * x] | from[2 * x + 1] << 8;
      to[x] = static_cast<uint8_t>(std::min(word >> shift, 255));
    }
  }
}

void grey_from_packed_ref(const RawImage& in, int group, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  PIRVS_ASSERT(group == 3 || group == 5);
  const int pixels = group - 1;
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    for (int x = 0; x < in.width; ++x) to[x] = from[x / pixels * group + x % pixels];
  }
}

void grey_from_bayer_ref(const RawImage& in, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 1 && in.height > 1 && out_stride >= in.width);
  for (int y = 0; y + 1 < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    for (int x = 0; x + 1 < in.width; ++x) {
      const uint8_t* const below = from + in.stride;
      const int sum = from[x] + from[x + 1] + below[x] + below[x + 1];
      to[x] = static_cast<uint8_t>((sum + 2) / 4);
    }
    to[in.width - 1] = to[in.width - 2];
  }
  uint8_t* const last = out + static_cast<ptrdiff_t>(in.height - 1) * out_stride;
  std::copy(last - out_stride, last - out_stride + in.width, last);
}

void grey_from_rgb_ref(const RawImage& in, bool blue_first, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  const int red = blue_first ? 2 : 0;
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    for (int x = 0; x < in.width; ++x) {
      const uint8_t* const pixel = from + 3 * x;
      const int sum =
          kRedWeight * pixel[red] + kGreenWeight * pixel[1] + kBlueWeight * pixel[2 - red];
      to[x] = static_cast<uint8_t>((sum + 128) >> 8);
    }
  }
}

void grey_from_limited_ref(const RawImage& in, uint8_t* out, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width);
  constexpr int kHalf = 1 << (kVideoShift - 1);
  for (int y = 0; y < in.height; ++y) {
    const uint8_t* const from = in.data + static_cast<ptrdiff_t>(y) * in.stride;
    uint8_t* const to = out + static_cast<ptrdiff_t>(y) * out_stride;
    for (int x = 0; x < in.width; ++x) {
      const int above = std::max(0, from[x] - kVideoBlack);
      to[x] = static_cast<uint8_t>(std::min((above * kVideoGain + kHalf) >> kVideoShift, 255));
    }
  }
}

}  // namespace pirvs
