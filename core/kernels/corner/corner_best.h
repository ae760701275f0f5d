// How both variants compare pixels. Private to core/kernels/corner.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/assert.h"
#include "core/kernels/corner/corner.h"

namespace pirvs::corner_detail {

// The sums are 25 Sobel products, and Sobel is 8 times the gradient.
inline constexpr float kScale = 1.0f / (25.0f * 8.0f * 8.0f);

inline void check(const ImageView& im, int x0, int y0, int w, int h) {
  PIRVS_ASSERT(w > 0 && h > 0 && w <= kCornerSizeMax && h <= kCornerSizeMax);
  PIRVS_ASSERT(x0 >= kCornerMargin_px && y0 >= kCornerMargin_px);
  PIRVS_ASSERT(x0 + w + kCornerMargin_px <= im.width && y0 + h + kCornerMargin_px <= im.height);
}

// The best so far. xx, xy, yy: sums over the window, below 25 * 1020^2 < 2^25.
struct Best {
  float eigenvalue;  // of the sums, not scaled
  int x = 0, y = 0;
  bool found = false;

  explicit Best(float response_min) : eigenvalue(response_min * (1.0f / kScale)) {}

  void offer(int32_t sum_xx, int32_t sum_xy, int32_t sum_yy, int at_x, int at_y) {
    const float xx = static_cast<float>(sum_xx), xy = static_cast<float>(sum_xy);
    const float yy = static_cast<float>(sum_yy);
    const float xx_rest = xx - eigenvalue, yy_rest = yy - eigenvalue;
    if (!(xx_rest > 0.0f && yy_rest > 0.0f && xx_rest * yy_rest > xy * xy)) return;
    const float mean = 0.5f * (xx + yy), half = 0.5f * (xx - yy);
    const float smaller = mean - std::sqrt(half * half + xy * xy);
    if (!(smaller > eigenvalue)) return;  // the two forms round differently
    eigenvalue = smaller;
    x = at_x;
    y = at_y;
    found = true;
  }

  bool finish(Corner& out) const {
    if (!found) return false;
    out = {static_cast<int16_t>(x), static_cast<int16_t>(y), eigenvalue * kScale};
    return true;
  }
};

}  // namespace pirvs::corner_detail
