#include "core/kernels/pyramid/pyramid.h"
#include "core/kernels/pyramid/pyramid_border.h"

namespace pirvs {

void pyramid_down_ref(const ImageView& in, uint8_t* out, int out_stride) {
  constexpr int kWeights[5] = {1, 4, 6, 4, 1};
  pyramid_detail::check(in, out_stride);
  for (int y = 0; y < (in.height + 1) / 2; ++y)
    for (int x = 0; x < (in.width + 1) / 2; ++x) {
      int sum = 0;
      for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 5; ++i)
          sum += kWeights[j] * kWeights[i] *
                 in.row(pyramid_detail::mirror(
                     2 * y + j - 2, in.height))[pyramid_detail::mirror(2 * x + i - 2, in.width)];
      out[static_cast<int64_t>(y) * out_stride + x] = static_cast<uint8_t>((sum + 128) >> 8);
    }
}

}  // namespace pirvs
