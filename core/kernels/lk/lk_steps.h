// What both variants of lk share: where to sample, and the few float operations after the sums.
// Private to core/kernels/lk.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/assert.h"
#include "core/kernels/lk/lk.h"

namespace pirvs::lk {

// A window of bilinear samples: sample (i, j) lies between pixels first[j * stride + i] and its
// right, lower and lower right neighbours.
struct Window {
  const uint8_t* first;
  int stride;
  int wx;      // weight of the right pixel, 0..127, in 1/128
  int wy;      // weight of the lower pixel, 0..32767, in 1/32768
  float x, y;  // position really sampled, px
};

// The window of kLkSize + 2 * border samples in both directions around x, y.
// size + 1 pixels must exist in both directions, as no weight is skipped when it is zero.
inline bool place(const ImageView& im, float x, float y, int border, Window& out) {
  const float radius_px = 0.5f * (kLkSize - 1) + static_cast<float>(border);
  const float left_px = x - radius_px, top_px = y - radius_px;
  const int size = kLkSize + 2 * border;
  // Written so that a NaN fails. im.width - size is the first corner that does not fit.
  if (!(left_px >= 0.0f && left_px < static_cast<float>(im.width - size))) return false;
  if (!(top_px >= 0.0f && top_px < static_cast<float>(im.height - size))) return false;
  const int column = static_cast<int>(left_px), row = static_cast<int>(top_px);
  out.first = im.row(row) + column;
  out.stride = im.stride;
  out.wx = static_cast<int>((left_px - static_cast<float>(column)) * 128.0f);
  out.wy = static_cast<int>((top_px - static_cast<float>(row)) * 32768.0f);
  out.x = static_cast<float>(column) + static_cast<float>(out.wx) * (1.0f / 128.0f) + radius_px;
  out.y = static_cast<float>(row) + static_cast<float>(out.wy) * (1.0f / 32768.0f) + radius_px;
  return true;
}

// Horizontal blend of two pixels, weights in 1/128: 0..255 * 128.
inline int blend_row_ref(const uint8_t* p, int wx) { return p[0] * (128 - wx) + p[1] * wx; }

// One bilinear sample of the window, grey * 32: the reference. The vertical blend is rounded at
// grey * 128, as vqrdmulh does, then brought to * 32.
inline int16_t sample(const Window& w, int column, int row) {
  const uint8_t* p = w.first + static_cast<int64_t>(row) * w.stride + column;
  const int upper = blend_row_ref(p, w.wx), lower = blend_row_ref(p + w.stride, w.wx);
  const int blended = upper + ((2 * (lower - upper) * w.wy + 32768) >> 16);
  return static_cast<int16_t>((blended + 2) >> 2);
}

inline constexpr int kPixels = kLkSize * kLkSize;

struct GradientSums {
  int32_t x, y, xx, xy, yy;
};

// Covariance = mean of products - product of means, exact in int64:
// kPixels * xx < 256 * 256 * 1020^2 < 2^37 and x^2 <= (256 * 1020)^2 < 2^37.
inline float covariance(int32_t products, int32_t sum_a, int32_t sum_b) {
  const int64_t scaled = static_cast<int64_t>(kPixels) * products -
                         static_cast<int64_t>(sum_a) * static_cast<int64_t>(sum_b);
  return static_cast<float>(scaled) * (1.0f / (kPixels * kPixels * 8.0f * 8.0f));
}

inline void finish(const GradientSums& sums, const Window& at, float x, float y, LkPatch& out) {
  out.sum_gx = sums.x;
  out.sum_gy = sums.y;
  out.h_xx = covariance(sums.xx, sums.x, sums.x);
  out.h_xy = covariance(sums.xy, sums.x, sums.y);
  out.h_yy = covariance(sums.yy, sums.y, sums.y);
  const float half_sum = 0.5f * (out.h_xx + out.h_yy),
              half_difference = 0.5f * (out.h_xx - out.h_yy);
  out.eigenvalue_min =
      half_sum - std::sqrt(half_difference * half_difference + out.h_xy * out.h_xy);
  out.x_rest_px = x - at.x;
  out.y_rest_px = y - at.y;
  out.usable = out.eigenvalue_min >= kLkEigenvalueMin;
}

// d = image - template, grey * 32, and its products with the gradient.
struct DifferenceSums {
  int32_t d, d_gx, d_gy;
};

// Template window and image window differ by sum H^-1 g (d - mean d).
// kPixels * d_gx < 2^39 and d * sum_gx < 2^21 * 2^18 fit int64.
inline void solve(const LkPatch& patch, const DifferenceSums& sums, float& step_x, float& step_y) {
  constexpr float kScale = 1.0f / (kPixels * kPixels * 32.0f * 8.0f);
  const float b_x = kScale * static_cast<float>(static_cast<int64_t>(kPixels) * sums.d_gx -
                                                static_cast<int64_t>(sums.d) * patch.sum_gx);
  const float b_y = kScale * static_cast<float>(static_cast<int64_t>(kPixels) * sums.d_gy -
                                                static_cast<int64_t>(sums.d) * patch.sum_gy);
  const float determinant = patch.h_xx * patch.h_yy - patch.h_xy * patch.h_xy;
  step_x = -(patch.h_yy * b_x - patch.h_xy * b_y) / determinant;
  step_y = -(patch.h_xx * b_y - patch.h_xy * b_x) / determinant;
}

// Mean of d over the patch, rounded, grey * 32. kPixels is a power of two.
inline int16_t mean(const DifferenceSums& sums) {
  return static_cast<int16_t>((sums.d + kPixels / 2) >> 8);
}

// Variant has: static DifferenceSums difference(const Window&, const LkPatch&, int16_t* d)
//              static int32_t sum_abs(const int16_t* d, int16_t mean)
template <class Variant>
bool align(const ImageView& im, const LkPatch& patch, float& x, float& y, int iterations_max,
           float step_min_px, float& residual_grey) {
  PIRVS_ASSERT(patch.usable);
  PIRVS_ASSERT(iterations_max >= 1);
  alignas(32) int16_t d[kPixels];
  DifferenceSums sums;
  float at_x = x - patch.x_rest_px, at_y = y - patch.y_rest_px;
  for (int i = 0; i < iterations_max; ++i) {
    Window window;
    if (!place(im, at_x, at_y, 0, window)) return false;
    sums = Variant::difference(window, patch, d);
    float step_x, step_y;
    solve(patch, sums, step_x, step_y);
    at_x = window.x + step_x;
    at_y = window.y + step_y;
    if (step_x * step_x + step_y * step_y < step_min_px * step_min_px) break;
  }
  x = at_x + patch.x_rest_px;
  y = at_y + patch.y_rest_px;
  residual_grey = static_cast<float>(Variant::sum_abs(d, mean(sums))) * (1.0f / (kPixels * 32.0f));
  return true;
}

}  // namespace pirvs::lk
