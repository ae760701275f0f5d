// 8-bit grey out of what cameras give: the luma of YUYV and UYVY, grey of 10, 12 or 16 bits, also
// packed, Bayer mosaics, RGB, and the limited range of video.
// In      grey_from_pairs: two bytes a pixel, of which the first is its luma (YUYV; UYVY from its
//         second byte on). grey_from_words: two bytes a pixel, the lower one first; `shift` bits
//         are dropped: 2 for Y10, 4 for Y12, 8 for Y16. grey_from_packed: groups of `group` bytes,
//         the upper 8 bits of each pixel and then one byte of all their lower bits: 5 for 10 bits
//         (4 px), 3 for 12 bits (2 px). grey_from_bayer: a mosaic of 8 bits, 2 x 2 px and more; of
//         more bits: grey_from_words or _packed first. grey_from_rgb: three bytes a pixel, red
//         first (RGB24), or blue (BGR24). grey_from_limited: 16 is black and 235 is white.
//         in_stride in bytes, 1 x 1 px and more.
// Out     8-bit grey, out_stride >= width. Words too large for their shift become 255.
//         Bayer: the mean of this pixel, the ones right and below, and the one between them: a red,
//         a blue and two greens, whatever the mosaic begins with. Half a pixel off to the right and
//         below, as the calibration from such images is. The last row and column repeat their
//         neighbours. out of bayer and limited may be in.data with its stride.
//         Reads exactly 2 * width - 1 bytes of a row of pairs, 2 * width of a row of words,
//         3 * width of a row of RGB, width of the others; of a packed row none behind the last
//         pixel's.
// Errors  None. Asserts the size, that shift is 0 to 8, group 3 or 5. Beyond 16 and 235: 0, 255.
// Cost    752 x 480, x86-64 (make bench K=grey): pairs 0.013 ms, words 0.05 ms, packed
//         0.024 ms, bayer 0.12 ms, rgb 0.31 ms (by SIMDe's vld3), limited 0.07 ms.
// Goal    A72 cycles: grey_from_pairs 1 a pixel, grey_from_words 1.2 a pixel.
// Source  V4L2, "YUV Formats", "Luma-Only Formats": V4L2_PIX_FMT_YUYV, UYVY, Y10, Y12, Y16, Y10P;
//         ITU-R BT.601 for the weights of red, green and blue and for the limited range.
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
void grey_from_packed_ref(const RawImage& in, int group, uint8_t* out, int out_stride);
void grey_from_packed_neon(const RawImage& in, int group, uint8_t* out, int out_stride);
void grey_from_bayer_ref(const RawImage& in, uint8_t* out, int out_stride);
void grey_from_bayer_neon(const RawImage& in, uint8_t* out, int out_stride);
void grey_from_rgb_ref(const RawImage& in, bool blue_first, uint8_t* out, int out_stride);
void grey_from_rgb_neon(const RawImage& in, bool blue_first, uint8_t* out, int out_stride);
void grey_from_limited_ref(const RawImage& in, uint8_t* out, int out_stride);
void grey_from_limited_neon(const RawImage& in, uint8_t* out, int out_stride);

// Sums to 256: white stays white.
inline constexpr int kRedWeight = 77, kGreenWeight = 150, kBlueWeight = 29;
// 255 / 219 in 128ths, so that 235 becomes 255.
inline constexpr int kVideoBlack = 16, kVideoGain = 149, kVideoShift = 7;

inline void grey_from_pairs(const RawImage& in, uint8_t* out, int out_stride) {
  grey_from_pairs_neon(in, out, out_stride);
}
inline void grey_from_words(const RawImage& in, int shift, uint8_t* out, int out_stride) {
  grey_from_words_neon(in, shift, out, out_stride);
}
inline void grey_from_packed(const RawImage& in, int group, uint8_t* out, int out_stride) {
  grey_from_packed_neon(in, group, out, out_stride);
}
inline void grey_from_bayer(const RawImage& in, uint8_t* out, int out_stride) {
  grey_from_bayer_neon(in, out, out_stride);
}
inline void grey_from_rgb(const RawImage& in, bool blue_first, uint8_t* out, int out_stride) {
  grey_from_rgb_neon(in, blue_first, out, out_stride);
}
inline void grey_from_limited(const RawImage& in, uint8_t* out, int out_stride) {
  grey_from_limited_neon(in, out, out_stride);
}

}  // namespace pirvs
