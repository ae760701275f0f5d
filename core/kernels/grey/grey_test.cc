#include "core/kernels/grey/grey.h"

#include <random>
#include <vector>

#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

using testing::PageEnd;

// Raw rows whose last byte is the last readable one.
struct Raw {
  PageEnd memory;
  RawImage image;

  Raw(int width, int height, int stride, int row_bytes, int content)
      : memory(size_t(height - 1) * size_t(stride) + size_t(row_bytes)),
        image{memory.data(), stride, width, height} {
    std::mt19937 random(uint32_t(width + 100 * content));
    for (size_t i = 0; i < memory.size(); ++i) {
      memory.data()[i] = content == 0 ? 0 : content == 1 ? 255 : uint8_t(random());
    }
  }
};

template <class Ref, class Neon>
void expect_same(const Raw& raw, Ref&& ref, Neon&& neon) {
  const int stride = raw.image.width + 3;
  PageEnd a(size_t(raw.image.height - 1) * size_t(stride) + size_t(raw.image.width));
  PageEnd b(a.size());
  std::memset(a.data(), 7, a.size());
  std::memset(b.data(), 7, b.size());
  ref(raw.image, a.data(), stride);
  neon(raw.image, b.data(), stride);
  ASSERT_EQ(std::memcmp(a.data(), b.data(), a.size()), 0) << raw.image.width;
}

TEST(grey, neon_equals_reference) {
  for (int content = 0; content < 3; ++content) {
    for (const int height : {1, 2, 5}) {
      for (int width = 1; width < 70; ++width) {
        const int stride = 2 * width + width % 4;
        expect_same(Raw(width, height, stride, 2 * width - 1, content), grey_from_pairs_ref,
                    grey_from_pairs_neon);
        for (const int shift : {0, 2, 4, 8}) {
          const auto words = [shift](auto* kernel) {
            return [=](const RawImage& in, uint8_t* out, int out_stride) {
              kernel(in, shift, out, out_stride);
            };
          };
          expect_same(Raw(width, height, stride, 2 * width, content), words(grey_from_words_ref),
                      words(grey_from_words_neon));
        }
      }
    }
  }
}

TEST(grey, neon_equals_reference_for_packed_bits) {
  for (const int group : {3, 5}) {
    const auto packed = [group](auto* kernel) {
      return [=](const RawImage& in, uint8_t* out, int out_stride) {
        kernel(in, group, out, out_stride);
      };
    };
    for (int content = 0; content < 3; ++content) {
      for (const int height : {1, 2, 5}) {
        for (int width = 1; width < 140; ++width) {
          const int pixels = group - 1;
          const int bytes = (width - 1) / pixels * group + (width - 1) % pixels + 1;
          expect_same(Raw(width, height, bytes + width % 4, bytes, content),
                      packed(grey_from_packed_ref), packed(grey_from_packed_neon));
        }
      }
    }
  }
}

TEST(grey, neon_equals_reference_for_colour) {
  const auto rgb = [](auto* kernel, bool blue_first) {
    return [=](const RawImage& in, uint8_t* out, int out_stride) {
      kernel(in, blue_first, out, out_stride);
    };
  };
  for (int content = 0; content < 3; ++content) {
    for (const int height : {1, 2, 5}) {
      for (int width = 1; width < 70; ++width) {
        const int stride = width + width % 4;
        const Raw grey(width, height, stride, width, content);
        expect_same(grey, grey_from_limited_ref, grey_from_limited_neon);
        if (width > 1 && height > 1) expect_same(grey, grey_from_bayer_ref, grey_from_bayer_neon);
        const Raw colour(width, height, 3 * width + width % 4, 3 * width, content);
        for (const bool blue_first : {false, true}) {
          expect_same(colour, rgb(grey_from_rgb_ref, blue_first),
                      rgb(grey_from_rgb_neon, blue_first));
        }
      }
    }
  }
}

// A mosaic of one colour is one grey, whatever its first pixel is; and so in place.
TEST(grey, bayer_has_no_pattern_left) {
  constexpr int kWidth = 37, kHeight = 6, kRed = 200, kGreen = 90, kBlue = 20;
  constexpr int kGrey = (kRed + 2 * kGreen + kBlue + 2) / 4;
  for (const int first : {0, 1, 2, 3}) {  // RGGB, GRBG, GBRG, BGGR
    uint8_t mosaic[kWidth * kHeight], out[kWidth * kHeight];
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const int even_x = (x + first) % 2, even_y = (y + first / 2) % 2;
        const int colour = even_x == even_y ? (even_x == 0 ? kRed : kBlue) : kGreen;
        mosaic[y * kWidth + x] = uint8_t(colour);
      }
    }
    grey_from_bayer({mosaic, kWidth, kWidth, kHeight}, out, kWidth);
    grey_from_bayer({mosaic, kWidth, kWidth, kHeight}, mosaic, kWidth);
    for (int i = 0; i < kWidth * kHeight; ++i) {
      ASSERT_EQ(out[i], kGrey) << first << ' ' << i;
      ASSERT_EQ(mosaic[i], kGrey) << first << ' ' << i;
    }
  }
}

TEST(grey, knows_red_from_blue_and_stretches_the_range_of_video) {
  const uint8_t rgb[] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
  uint8_t out[5];
  grey_from_rgb({rgb, 12, 4, 1}, false, out, 4);
  EXPECT_EQ(out[0], 77);
  EXPECT_EQ(out[1], 149);
  EXPECT_EQ(out[2], 29);
  EXPECT_EQ(out[3], 255);
  grey_from_rgb({rgb, 12, 4, 1}, true, out, 4);
  EXPECT_EQ(out[0], 29);
  const uint8_t video[] = {0, 16, 126, 235, 255};
  grey_from_limited({video, 5, 5, 1}, out, 5);
  EXPECT_EQ(out[0], 0);
  EXPECT_EQ(out[1], 0);
  EXPECT_EQ(out[2], 128);
  EXPECT_EQ(out[3], 255);
  EXPECT_EQ(out[4], 255);
}

TEST(grey, leaves_the_packed_lower_bits_out) {
  const uint8_t ten[] = {1, 2, 3, 4, 0xff, 5, 6}, twelve[] = {1, 2, 0xff, 3, 4, 0xff, 5, 6};
  uint8_t out[6];
  grey_from_packed({ten, 7, 6, 1}, 5, out, 6);
  for (int x = 0; x < 6; ++x) EXPECT_EQ(out[x], x + 1);
  grey_from_packed({twelve, 8, 6, 1}, 3, out, 6);
  for (int x = 0; x < 6; ++x) EXPECT_EQ(out[x], x + 1);
}

TEST(grey, takes_the_luma_and_the_upper_bits) {
  const uint8_t yuyv[] = {10, 128, 20, 128, 30, 128};
  uint8_t out[3];
  grey_from_pairs({yuyv, 6, 3, 1}, out, 3);
  EXPECT_EQ(out[0] + out[1] * 256 + out[2] * 65536, 10 + 20 * 256 + 30 * 65536);
  const uint8_t y10[] = {0xff, 0x03, 0x04, 0x00, 0xff, 0xff};  // 1023, 4, and no number of 10 bits
  grey_from_words({y10, 6, 3, 1}, 2, out, 3);
  EXPECT_EQ(out[0], 255);
  EXPECT_EQ(out[1], 1);
  EXPECT_EQ(out[2], 255);
}

}  // namespace
}  // namespace pirvs
