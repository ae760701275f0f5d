#include "core/kernels/grey/grey.h"

#include <random>
#include <vector>

#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

using testing::PageEnd;

// Raw rows whose last byte is the last readable one: `cut` bytes of the last pixel are not needed.
struct Raw {
  PageEnd memory;
  RawImage image;

  Raw(int width, int height, int stride, int cut, int content)
      : memory(size_t(height - 1) * size_t(stride) + size_t(2 * width - cut)),
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
        expect_same(Raw(width, height, stride, 1, content), grey_from_pairs_ref,
                    grey_from_pairs_neon);
        for (const int shift : {0, 2, 4, 8}) {
          const auto words = [shift](auto* kernel) {
            return [=](const RawImage& in, uint8_t* out, int out_stride) {
              kernel(in, shift, out, out_stride);
            };
          };
          expect_same(Raw(width, height, stride, 0, content), words(grey_from_words_ref),
                      words(grey_from_words_neon));
        }
      }
    }
  }
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
