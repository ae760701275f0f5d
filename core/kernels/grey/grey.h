// 8-bit grey out of what cameras give: the luma of YUYV and UYVY, and grey of 10, 12 or 16 bits.
// In      grey_from_pairs: two bytes a pixel, of which the first is its luma (YUYV; UYVY from its
//         second byte on). grey_from_words: two bytes a pixel, the lower one first; `shift` bits
//         are dropped: 2 for Y10, 4 for Y12, 8 for Y16. in_stride in bytes, 1 x 1 px and more.
// Out     8-bit grey, out_stride >= width. Words too large for their shift become 255.
//         Reads exactly 2 * width - 1 bytes of a row of pairs, 2 * width of a row of words.
// Errors  None. Asserts the size and that shift is 0 to 8.
// Cost    752 x 480, x86-64 (make bench K=grey): pairs 0.013 ms, words 0.05 ms.
// Goal    A72 cycles: grey_from_pairs 1 a pixel, grey_from_words 1.2 a pixel.
// Source  V4L2, "YUV Formats", "Luma-Only Formats": V4L2_PIX_FMT_YUYV, UYVY, Y10, Y12, Y16.
#pragma once

#include <cstdint>

namespace pirvs {

struct RawImage {
  const uint8_t* data = nullptr;
  int stride = 0;
  int width = 0, height = 0;
};

void grey_from_pairs_ref(const RawImage& in, uint8_t* out, int out_stride);
void grey_from_pairs_neon(const RawImage& in, uint8_t* out, int out_stride);
void grey_from_words_ref(const RawImage& in, int shift, uint8_t* out, int out_stride);
void grey_from_words_neon(const RawImage& in, int shift, uint8_t* out, int out_stride);

inline void grey_from_pairs(const RawImage& in, uint8_t* out, int out_stride) {
  grey_from_pairs_neon(in, out, out_stride);
}
inline void grey_from_words(const RawImage& in, int shift, uint8_t* out, int out_stride) {
  grey_from_words_neon(in, shift, out, out_stride);
}

}  // namespace pirvs
