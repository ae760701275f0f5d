// Histogram equalization of a grey image: makes each grey value about as frequent as the others.
// In      8-bit grey, 1 x 1 px and more, at most 2^24 pixels (a count of them is exact in float).
//         count_every: the histogram is that of every so many rows, from the first on.
// Out     8-bit grey of the same size, out_stride >= width. out may be in.data with in's stride.
//         An image of one value stays as it is. Same bytes as cv::equalizeHist if all are counted.
// Errors  None. Asserts the size.
// Cost    752 x 480: 0.16 ms x86-64 (make bench K=equalize), 0.08 of every fourth row. 5 KiB of
//         stack.
// Goal    A72 cycles: equalize 3.5 a pixel (make bench BOARD=qemu-virt).
// Source  OpenCV 4.6, imgproc/src/histogram.cpp, equalizeHist.
#pragma once

#include <cstdint>

#include "core/kernels/image.h"

namespace pirvs {

void equalize_ref(const ImageView& in, uint8_t* out, int out_stride, int count_every = 1);
void equalize_neon(const ImageView& in, uint8_t* out, int out_stride, int count_every = 1);

inline void equalize(const ImageView& in, uint8_t* out, int out_stride, int count_every = 1) {
  equalize_neon(in, out, out_stride, count_every);
}

}  // namespace pirvs
