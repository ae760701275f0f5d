// One level of an image pyramid: 5 x 5 binomial filter (1 4 6 4 1) / 16 in both directions, then
// every second pixel of every second row.
// In      8-bit grey, 1 x 1 px and more, at most kPyramidWidthMax wide.
// Out     (width + 1) / 2 x (height + 1) / 2 pixels, out_stride >= that width; must not overlap in.
//         Rounded to nearest. The border is mirrored without repeating the last pixel. Same bytes
//         as cv::pyrDown with BORDER_REFLECT_101.
// Frames  Pixel (x, y) of the output is centred on pixel (2 x, 2 y) of the input.
// Errors  None. Asserts the size.
// Cost    752 x 480: 0.036 ms x86-64 (make bench K=pyramid). 10 KiB of stack.
// Goal    A72 cycles: pyramid_down 1.2 a pixel of in (make bench BOARD=qemu-virt).
// Source  Burt, Adelson, "The Laplacian Pyramid as a Compact Image Code", 1983, a = 3/8.
#pragma once

#include <cstdint>

#include "core/kernels/image.h"

namespace pirvs {

inline constexpr int kPyramidWidthMax = 2048;  // px

void pyramid_down_ref(const ImageView& in, uint8_t* out, int out_stride);
void pyramid_down_neon(const ImageView& in, uint8_t* out, int out_stride);

inline void pyramid_down(const ImageView& in, uint8_t* out, int out_stride) {
  pyramid_down_neon(in, out, out_stride);
}

}  // namespace pirvs
