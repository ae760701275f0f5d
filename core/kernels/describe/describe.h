// A 256-bit binary descriptor of the patch around a point (rotated BRIEF): bit i tells which of two
// smoothed pixels is darker. Compare two by hamming().
// In      8-bit grey; x, y at least kDescribeMargin_px from every border of the image;
//         cos_a, sin_a: unit vector, the patch's x axis in the image.
// Out     Descriptor. x, y are rounded to the pixel and the rotated pattern points as well.
//         Both variants and all machines give the same bits.
// Frames  Pixels, x right, y down, (0,0) = centre of the first pixel. Positive angles turn x to y.
// Errors  None. Asserts the position and that the vector is no longer than one.
// Cost    0.5 us x86-64 (make bench K=describe). 4 KiB of stack.
// Goal    A72 cycles: describe 4500 a call (make bench BOARD=qemu-virt).
// Source  Calonder et al., "BRIEF", ECCV 2010; turned as in Rublee et al., "ORB", ICCV 2011, 4.1;
//         pattern from tools/gen/brief_pattern.py. Smoothing: mean of 5 x 5 px, as a sum.
#pragma once

#include <cstdint>

#include "core/kernels/image.h"

namespace pirvs {

inline constexpr int kDescribeMargin_px = 20;

struct Descriptor {
  uint64_t w[4];
};

void describe_ref(const ImageView& im, float x, float y, float cos_a, float sin_a, Descriptor& out);
void describe_neon(const ImageView& im, float x, float y, float cos_a, float sin_a,
                   Descriptor& out);

inline void describe(const ImageView& im, float x, float y, float cos_a, float sin_a,
                     Descriptor& out) {
  describe_neon(im, x, y, cos_a, sin_a, out);
}

}  // namespace pirvs
