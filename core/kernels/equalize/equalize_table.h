// The step between the two passes of equalize. Private to core/kernels/equalize.
#pragma once

#include <cstdint>

#include "core/base/assert.h"
#include "core/kernels/equalize/equalize.h"

namespace pirvs::equalize_detail {

inline void check(const ImageView& in, int out_stride, int count_every) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && out_stride >= in.width && count_every > 0);
  PIRVS_ASSERT(static_cast<int64_t>(in.width) * in.height <= 1 << 24);
}

// table[v]: what grey value v becomes, for a histogram of every count_every-th row.
inline void make_table(const uint32_t (&histogram)[256], const ImageView& in, int count_every,
                       uint8_t (&table)[256]) {
  const int rows = (in.height + count_every - 1) / count_every;
  const uint32_t pixels = static_cast<uint32_t>(in.width * rows);
  int first = 0;
  while (histogram[first] == 0) ++first;  // ends: the image has a pixel
  if (histogram[first] == pixels) {
    for (int v = 0; v < 256; ++v) table[v] = static_cast<uint8_t>(v);
    return;
  }
  for (int v = 0; v <= first; ++v) table[v] = 0;
  const float scale = 255.0f / static_cast<float>(pixels - histogram[first]);
  uint32_t sum = 0;
  for (int v = first + 1; v < 256; ++v) {
    sum += histogram[v];
    // Adding 2^23 rounds to the nearest integer, ties to even. The product is below 255.5.
    const float rounded = static_cast<float>(sum) * scale + 8388608.0f;
    table[v] = static_cast<uint8_t>(static_cast<int>(rounded - 8388608.0f));
  }
}

}  // namespace pirvs::equalize_detail
