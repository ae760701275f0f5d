// Sub-pixel alignment of a 16 x 16 px patch between two images: inverse compositional
// Lucas-Kanade, translation only, blind to a brightness offset. One level of a pyramid; the driver
// goes over levels.
// In      8-bit grey. Positions in pixels of that image: the patch covers x - 7.5 .. x + 7.5.
// Out     lk_extract: the template and its Hessian, once per patch. lk_align: where the image looks
//         like the template. Bilinear samples: horizontal weights in 1/128 px, vertical ones in
//         1/32768 px; what the position loses by that is carried along and costs no accuracy.
// Frames  Pixels, x right, y down, (0,0) = centre of the first pixel.
// Errors  false: the patch (one pixel more on each side for lk_extract) leaves the image, or x, y
//         is not a number; then no output is changed. lk_align asserts patch.usable.
// Cost    x86-64: 55 ns per iteration, 75 ns per extraction (make bench K=lk).
//         Both variants and all machines give the same bits: sums are integers, the 2 x 2 solve is
//         a fixed order of float operations.
// Goal    A72 cycles: lk_extract 1300 a call, lk_align 650 an iteration.
// Source  Baker, Matthews, "Lucas-Kanade 20 Years On", IJCV 2004, section 3.2.1, W(x;p) = x + p.
#pragma once

#include <cstdint>

#include "core/kernels/image.h"

namespace pirvs {

inline constexpr int kLkSize = 16;  // px, both directions

struct LkPatch {
  alignas(32) int16_t t[kLkSize * kLkSize];   // template, grey * 32, 0..8160
  alignas(32) int16_t gx[kLkSize * kLkSize];  // gradient, grey / px * 8, -1020..1020
  alignas(32) int16_t gy[kLkSize * kLkSize];
  int32_t sum_gx, sum_gy;
  float h_xx, h_xy, h_yy;      // covariance of the gradient over the patch, grey^2 / px^2
  float eigenvalue_min;        // of that matrix
  float x_rest_px, y_rest_px;  // asked position minus sampled position
  bool usable;                 // eigenvalue_min reaches kLkEigenvalueMin
};

// grey^2 / px^2. Below it (gradient of 0.3 grey / px in the worst direction) noise decides.
inline constexpr float kLkEigenvalueMin = 0.1f;

bool lk_extract_ref(const ImageView& im, float x, float y, LkPatch& out);
bool lk_extract_neon(const ImageView& im, float x, float y, LkPatch& out);

// Starts at x, y and does at most iterations_max (>= 1) steps, fewer if one is below step_min_px.
// residual_grey: mean of |image - template| over the patch, offset removed, at the last sampled
// position, that is before the last step.
bool lk_align_ref(const ImageView& im, const LkPatch& patch, float& x, float& y, int iterations_max,
                  float step_min_px, float& residual_grey);
bool lk_align_neon(const ImageView& im, const LkPatch& patch, float& x, float& y,
                   int iterations_max, float step_min_px, float& residual_grey);

inline bool lk_extract(const ImageView& im, float x, float y, LkPatch& out) {
  return lk_extract_neon(im, x, y, out);
}
inline bool lk_align(const ImageView& im, const LkPatch& patch, float& x, float& y,
                     int iterations_max, float step_min_px, float& residual_grey) {
  return lk_align_neon(im, patch, x, y, iterations_max, step_min_px, residual_grey);
}

}  // namespace pirvs
