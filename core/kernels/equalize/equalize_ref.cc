#include "core/kernels/equalize/equalize.h"
#include "core/kernels/equalize/equalize_table.h"

namespace pirvs {

void equalize_ref(const ImageView& in, uint8_t* out, int out_stride, int count_every) {
  equalize_detail::check(in, out_stride, count_every);
  uint32_t histogram[256] = {};
  for (int y = 0; y < in.height; y += count_every)
    for (int x = 0; x < in.width; ++x) ++histogram[in.row(y)[x]];
  uint8_t table[256];
  equalize_detail::make_table(histogram, in, count_every, table);
  for (int y = 0; y < in.height; ++y)
    for (int x = 0; x < in.width; ++x)
      out[static_cast<int64_t>(y) * out_stride + x] = table[in.row(y)[x]];
}

}  // namespace pirvs
