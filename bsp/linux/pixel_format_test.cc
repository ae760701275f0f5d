#include "bsp/linux/pixel_format.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <vector>

namespace pirvs::bsp {
namespace {

constexpr int kWidth = 38, kHeight = 6, kGrey = 90;

const PixelFormat& format_of(uint32_t code) {
  for (const PixelFormat& format : pixel_formats()) {
    if (format.code == code) return format;
  }
  ADD_FAILURE() << "unknown: " << code;
  return *pixel_formats().begin();
}

TEST(pixel_format, packed_rows_are_as_long_as_their_groups) {
  EXPECT_EQ(format_of(V4L2_PIX_FMT_Y10P).row_bytes(40), 50);
  EXPECT_EQ(format_of(V4L2_PIX_FMT_Y10P).row_bytes(41), 55);
  EXPECT_EQ(format_of(V4L2_PIX_FMT_SRGGB12P).row_bytes(40), 60);
  EXPECT_EQ(format_of(V4L2_PIX_FMT_YUYV).row_bytes(40), 80);
}

// One grey all over; the lower bits are noise.
TEST(pixel_format, packed_images_become_grey) {
  for (const uint32_t code : {V4L2_PIX_FMT_Y10P, v4l2_fourcc('Y', '1', '2', 'P'),
                              V4L2_PIX_FMT_SRGGB10P, V4L2_PIX_FMT_SGBRG12P}) {
    const PixelFormat& format = format_of(code);
    const int stride = format.row_bytes(kWidth) + 7;
    std::vector<uint8_t> raw(size_t(stride * kHeight), kGrey), out(size_t(kWidth * kHeight));
    for (int y = 0; y < kHeight; ++y) {
      for (int at = format.bytes - 1; at < stride; at += format.bytes) {
        raw[size_t(y * stride + at)] = uint8_t(37 * at);
      }
    }
    const RawBuffer in = {raw.data(), raw.size(), stride, kWidth, kHeight, false};
    ASSERT_TRUE(make_grey(format, in, nullptr, out.data()));
    for (const uint8_t grey : out) ASSERT_EQ(grey, kGrey) << code;
  }
}

}  // namespace
}  // namespace pirvs::bsp
