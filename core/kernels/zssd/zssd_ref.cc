#include "core/kernels/zssd/zssd.h"

namespace pirvs {
namespace {

uint32_t zssd(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b,
              int size) {
  int64_t sum = 0, squares = 0;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const int d = a[y * stride_a + x] - b[y * stride_b + x];
      sum += d;
      squares += d * d;
    }
  return static_cast<uint32_t>(squares - sum * sum / (size * size));
}

}  // namespace

uint32_t zssd_8x8_ref(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b) {
  return zssd(a, stride_a, b, stride_b, 8);
}

uint32_t zssd_16x16_ref(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b,
                        ptrdiff_t stride_b) {
  return zssd(a, stride_a, b, stride_b, 16);
}

}  // namespace pirvs
