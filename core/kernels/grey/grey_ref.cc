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

}  // namespace pirvs
