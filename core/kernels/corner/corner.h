// The best corner of a rectangle (Shi-Tomasi): where the smaller eigenvalue of the gradient's
// moment matrix, 3 x 3 Sobel gradients over a 5 x 5 px window, is largest.
// In      8-bit grey. Rectangle [x0, x0 + w) x [y0, y0 + h), 1..kCornerSizeMax px in each
//         direction; 3 px around it are read, and 4 must be in the image. response_min: grey^2 /
//         px^2, the smallest response that counts.
// Out     Corner: pixel and response, grey^2 / px^2, mean over the window. Among equals the first
//         one in raster order.
// Frames  Pixels, x right, y down.
// Errors  false: no response above response_min; out is left alone. Asserts the rectangle.
// Cost    40 x 40 px: 2.7 us x86-64 (make bench K=corner). 4 KiB of stack. A square root is taken
//         only where a pixel beats the best m so far: if xx, yy > m and (xx - m) (yy - m) > xy^2.
//         In float this test is monotonic in m too, so testing several pixels against an old m
//         never loses one, and both variants agree in every bit.
// Goal    A72 cycles: corner_best 15 a pixel, over 36 x 36 px (make bench BOARD=qemu-virt).
// Source  Shi, Tomasi, "Good Features to Track", CVPR 1994, section 3.
#pragma once

#include <cstdint>

#include "core/kernels/image.h"

namespace pirvs {

inline constexpr int kCornerSizeMax = 64;   // px
inline constexpr int kCornerMargin_px = 4;  // around the rectangle

struct Corner {
  int16_t x, y;
  float response;  // grey^2 / px^2
};

bool corner_best_ref(const ImageView& im, int x0, int y0, int w, int h, float response_min,
                     Corner& out);
bool corner_best_neon(const ImageView& im, int x0, int y0, int w, int h, float response_min,
                      Corner& out);

inline bool corner_best(const ImageView& im, int x0, int y0, int w, int h, float response_min,
                        Corner& out) {
  return corner_best_neon(im, x0, y0, w, h, response_min, out);
}

}  // namespace pirvs
