#include "core/kernels/describe/describe.h"

#include <cmath>

#include "core/kernels/describe/describe_place.h"
#include "core/kernels/hamming/hamming.h"
#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

using testing::Image;

void expect_same(const ImageView& im, float x, float y, float angle) {
  Descriptor ref, neon;
  describe_ref(im, x, y, std::cos(angle), std::sin(angle), ref);
  describe_neon(im, x, y, std::cos(angle), std::sin(angle), neon);
  for (int k = 0; k < 4; ++k) ASSERT_EQ(ref.w[k], neon.w[k]) << x << " " << y << " " << angle;
}

TEST(describe, neon_equals_reference) {
  for (int content = 0; content < testing::kContents; ++content)
    for (int extra = 0; extra < 4; ++extra) {
      const int width = 41 + 9 * extra, height = 41 + 5 * extra;
      Image im(width, height, width + extra * 3);
      fill(im, content, static_cast<uint32_t>(extra));
      for (int i = 0; i < 80; ++i) {
        // The first ones touch the margin in every corner, up to the last byte of memory.
        const float x = i % 2 == 0 ? 20.0f : static_cast<float>(width - 21);
        const float y = i / 2 % 2 == 0 ? 20.0f : static_cast<float>(height - 21);
        const float inwards = i < 4 ? 0.0f : static_cast<float>(extra * (i % 9)) / 5;
        expect_same(im.view(), x + (i % 2 == 0 ? inwards : -inwards),
                    y + (i / 2 % 2 == 0 ? inwards : -inwards), 0.0817f * static_cast<float>(i));
      }
    }
}

TEST(describe, pattern_is_what_it_claims) {
  using namespace describe_detail;
  for (int i = 0; i < 256; ++i) {
    EXPECT_LE(std::hypot(kAx[i], kAy[i]), kRadius_px);
    EXPECT_LE(std::hypot(kBx[i], kBy[i]), kRadius_px);
    EXPECT_GE(std::hypot(kAx[i] - kBx[i], kAy[i] - kBy[i]), 5);
  }
}

// The same scene turned around its point, with other noise, stays near; another point is far.
TEST(describe, survives_rotation) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 3);
  Image im(101, 101), turned(101, 101);
  im.fill([&](int x, int y) { return testing::scene(0.7 * x, 0.7 * y) + noise(random); });
  Descriptor upright, elsewhere;
  describe(im.view(), 50, 50, 1, 0, upright);
  describe(im.view(), 61, 45, 1, 0, elsewhere);
  for (float angle = 0; angle < 6.3f; angle += 0.3f) {
    const double c = std::cos(angle), s = std::sin(angle);
    turned.fill([&](int x, int y) {
      const double dx = x - 50, dy = y - 50;
      return testing::scene(0.7 * (50 + c * dx + s * dy), 0.7 * (50 - s * dx + c * dy)) +
             noise(random);
    });
    Descriptor found;
    describe(turned.view(), 50, 50, static_cast<float>(c), static_cast<float>(s), found);
    EXPECT_LT(hamming(upright, found), 40) << angle;
    EXPECT_GT(hamming(elsewhere, found), 70) << angle;
  }
}

}  // namespace
}  // namespace pirvs
