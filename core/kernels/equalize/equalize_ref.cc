#include "core/kernels/equalize/equalize.h"
#include "core/kernels/equalize/equalize_table.h"

namespace pirvs {

void equalize_ref(const ImageView& in, uint8_t* out, int out_stride) {
  equalize_detail::check(in, out_stride);
  uint32_t histogram[256] = {};
  for (int y = 0; y < in.height; ++y)
    for (int x = 0; x < in.width; ++x) ++histogram[in.row(y)[x]];
  uint8_t table[256];
  equalize_detail::make_table(histogram, static_cast<uint32_t>(in.width * in.height), table);
  for (int y = 0; y < in.height; ++y)
    for (int x = 0; x < in.width; ++x)
      out[static_cast<int64_t>(y) * out_stride + x] = table[in.row(y)[x]];
}

}  // namespace pirvs
