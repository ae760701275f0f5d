// What both variants of describe agree on. Private to core/kernels/describe.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/assert.h"
#include "core/kernels/describe/describe.h"
#include "core/kernels/describe/describe_pattern.h"

namespace pirvs::describe_detail {

inline constexpr int kRadius_px = 15;                // of the pattern
inline constexpr int kSmooth_px = 2;                 // half of 5
inline constexpr int kSide_px = 2 * kRadius_px + 1;  // of the smoothed patch
inline constexpr int kUnit = 1024;                   // cos, sin in 1/1024

struct Place {
  int x, y;              // px
  int16_t cos_a, sin_a;  // in 1/kUnit
};

inline Place place(const ImageView& im, float x, float y, float cos_a, float sin_a) {
  // As comparisons that fail on NaN. Rounding moves a point by half a pixel, and 18 px are read.
  PIRVS_ASSERT(x >= kDescribeMargin_px - 1 &&
               x <= static_cast<float>(im.width - kDescribeMargin_px));
  PIRVS_ASSERT(y >= kDescribeMargin_px - 1 &&
               y <= static_cast<float>(im.height - kDescribeMargin_px));
  PIRVS_ASSERT(cos_a * cos_a + sin_a * sin_a <= 1.001f);
  const auto round = [](float v) { return static_cast<int>(std::floor(v + 0.5f)); };
  return {round(x), round(y), static_cast<int16_t>(round(cos_a * kUnit)),
          static_cast<int16_t>(round(sin_a * kUnit))};
}

}  // namespace pirvs::describe_detail
