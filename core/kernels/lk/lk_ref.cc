#include <cstdlib>

#include "core/kernels/lk/lk.h"
#include "core/kernels/lk/lk_steps.h"

namespace pirvs {
namespace {

using lk::kPixels;
using lk::sample;

struct Reference {
  static lk::DifferenceSums difference(const lk::Window& window, const LkPatch& patch, int16_t* d) {
    lk::DifferenceSums sums = {};
    for (int i = 0; i < kPixels; ++i) {
      d[i] = static_cast<int16_t>(sample(window, i % kLkSize, i / kLkSize) - patch.t[i]);
      sums.d += d[i];
      sums.d_gx += d[i] * patch.gx[i];
      sums.d_gy += d[i] * patch.gy[i];
    }
    return sums;
  }

  static int32_t sum_abs(const int16_t* d, int16_t mean) {
    int32_t sum = 0;
    for (int i = 0; i < kPixels; ++i) sum += std::abs(d[i] - mean);
    return sum;
  }
};

}  // namespace

bool lk_extract_ref(const ImageView& im, float x, float y, LkPatch& out) {
  lk::Window window;
  if (!lk::place(im, x, y, 1, window)) return false;
  lk::GradientSums sums = {};
  for (int i = 0; i < kPixels; ++i) {
    const int column = i % kLkSize + 1, row = i / kLkSize + 1;
    const int dx = sample(window, column + 1, row) - sample(window, column - 1, row);
    const int dy = sample(window, column, row + 1) - sample(window, column, row - 1);
    const int gx = (dx + 4) >> 3, gy = (dy + 4) >> 3;
    out.t[i] = sample(window, column, row);
    out.gx[i] = static_cast<int16_t>(gx);
    out.gy[i] = static_cast<int16_t>(gy);
    sums.x += gx;
    sums.y += gy;
    sums.xx += gx * gx;
    sums.xy += gx * gy;
    sums.yy += gy * gy;
  }
  lk::finish(sums, window, x, y, out);
  return true;
}

bool lk_align_ref(const ImageView& im, const LkPatch& patch, float& x, float& y, int iterations_max,
                  float step_min_px, float& residual_grey) {
  return lk::align<Reference>(im, patch, x, y, iterations_max, step_min_px, residual_grey);
}

}  // namespace pirvs
