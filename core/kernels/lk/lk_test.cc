#include "core/kernels/lk/lk.h"

#include <cmath>
#include <cstring>

#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

using testing::Image;

bool same(const LkPatch& a, const LkPatch& b) {
  return std::memcmp(a.t, b.t, sizeof a.t) == 0 && std::memcmp(a.gx, b.gx, sizeof a.gx) == 0 &&
         std::memcmp(a.gy, b.gy, sizeof a.gy) == 0 && a.sum_gx == b.sum_gx &&
         a.sum_gy == b.sum_gy && a.h_xx == b.h_xx && a.h_xy == b.h_xy && a.h_yy == b.h_yy &&
         a.eigenvalue_min == b.eigenvalue_min && a.x_rest_px == b.x_rest_px &&
         a.y_rest_px == b.y_rest_px && a.usable == b.usable;
}

// Extracts at x, y and aligns in other from there, by both variants.
void expect_same(const ImageView& im, const ImageView& other, float x, float y, int iterations) {
  LkPatch ref, neon;
  const bool extracted = lk_extract_ref(im, x, y, ref);
  ASSERT_EQ(extracted, lk_extract_neon(im, x, y, neon));
  if (!extracted) return;
  ASSERT_TRUE(same(ref, neon)) << x << " " << y;
  if (!ref.usable) return;
  float x_ref = x, y_ref = y, x_neon = x, y_neon = y, residual_ref = -1, residual_neon = -1;
  ASSERT_EQ(lk_align_ref(other, ref, x_ref, y_ref, iterations, 0.01f, residual_ref),
            lk_align_neon(other, neon, x_neon, y_neon, iterations, 0.01f, residual_neon));
  EXPECT_EQ(x_ref, x_neon);
  EXPECT_EQ(y_ref, y_neon);
  EXPECT_EQ(residual_ref, residual_neon);
}

TEST(lk, neon_equals_reference) {
  for (int content = 0; content < testing::kContents; ++content)
    for (int extra = 0; extra < 3; ++extra) {
      Image im(19 + 11 * extra, 19 + 7 * extra, 19 + 11 * extra + 13 * (extra % 2));
      Image other(im.view().width, im.view().height);
      fill(im, content, 1);
      fill(other, content == 0 ? 1 : content == 1 ? 0 : content, 2);
      std::mt19937 random(7);
      std::uniform_real_distribution<float> x(-2.0f, static_cast<float>(im.view().width + 2));
      std::uniform_real_distribution<float> y(-2.0f, static_cast<float>(im.view().height + 2));
      for (int i = 0; i < 300; ++i)
        expect_same(im.view(), other.view(), x(random), y(random), 1 + i % 5);
      // The nearest positions to all four borders, where the last byte of the image is read.
      const float right = static_cast<float>(im.view().width) - 9.5f;
      const float bottom = static_cast<float>(im.view().height) - 9.5f;
      for (const float px : {8.5f, std::nextafter(right, 0.0f)})
        for (const float py : {8.5f, std::nextafter(bottom, 0.0f)})
          expect_same(im.view(), other.view(), px, py, 1);
    }
}

// The largest products that the template can hold: full-scale stripes against their negative.
TEST(lk, extremes_do_not_overflow) {
  Image im(40, 40), negative(40, 40);
  for (const int period : {2, 3, 4, 8}) {
    im.fill([&](int x, int y) { return (x / period + y / period) % 2 * 255; });
    negative.fill([&](int x, int y) { return 255 - (x / period + y / period) % 2 * 255; });
    for (int i = 0; i < 64; ++i)
      expect_same(im.view(), negative.view(), 19.5f + static_cast<float>(i % 8) / 8,
                  19.5f + static_cast<float>(i / 8) / 8, 3);
  }
}

TEST(lk, refuses_what_leaves_the_image) {
  Image im(40, 30);
  fill(im, 4, 0);
  LkPatch patch, untouched;
  std::memset(&patch, 0, sizeof patch);
  untouched = patch;
  for (const auto& [x, y] : {std::pair{8.4f, 15.0f},
                             {30.5f, 15.0f},
                             {20.0f, 8.4f},
                             {20.0f, 20.5f},
                             {NAN, 15.0f},
                             {20.0f, NAN},
                             {INFINITY, 15.0f},
                             {-1e30f, 15.0f}}) {
    EXPECT_FALSE(lk_extract(im.view(), x, y, patch)) << x << " " << y;
    EXPECT_TRUE(same(patch, untouched));
  }
  ASSERT_TRUE(lk_extract(im.view(), 20.0f, 15.0f, patch));
  float x = 7.4f, y = 15.0f, residual = -1;
  EXPECT_FALSE(lk_align(im.view(), patch, x, y, 5, 0.01f, residual));
  EXPECT_EQ(x, 7.4f);
  EXPECT_EQ(residual, -1.0f);
}

TEST(lk, flat_patch_is_not_usable) {
  Image im(40, 40);
  im.fill([](int x, int) { return 3 * x; });  // gradient in one direction, and constant
  LkPatch patch;
  ASSERT_TRUE(lk_extract(im.view(), 20.0f, 20.0f, patch));
  EXPECT_FALSE(patch.usable);
}

// A scene moved by a known amount: the error must stay far below 0.05 px, whatever the fractions.
TEST(lk, finds_a_known_shift) {
  Image im(80, 80), moved(80, 80);
  fill(im, 4, 0);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> shift(-1.2f, 1.2f), place(28.0f, 50.0f);
  double square_sum = 0;
  constexpr int kCases = 200;
  for (int i = 0; i < kCases; ++i) {
    const float dx = shift(random), dy = shift(random), x0 = place(random), y0 = place(random);
    const double offset = i % 2 == 0 ? 0 : 0.2 * (i % 100);  // grey
    moved.fill([&](int x, int y) { return 0.9 * testing::scene(x - dx, y - dy) + offset; });
    im.fill([&](int x, int y) { return 0.9 * testing::scene(x, y); });
    LkPatch patch;
    ASSERT_TRUE(lk_extract(im.view(), x0, y0, patch));
    ASSERT_TRUE(patch.usable);
    float x = x0, y = y0, residual;
    ASSERT_TRUE(lk_align(moved.view(), patch, x, y, 20, 0.005f, residual));
    const double error_px = std::hypot(x - x0 - dx, y - y0 - dy);
    EXPECT_LT(error_px, 0.05) << x0 << " " << y0 << " by " << dx << " " << dy;
    EXPECT_LT(residual, 6.0f);
    square_sum += error_px * error_px;
  }
  EXPECT_LT(std::sqrt(square_sum / kCases), 0.02);
}

// The same image at the same place: nothing moves, not even by the rounding of the position.
TEST(lk, stays_where_nothing_moved) {
  Image im(60, 60);
  fill(im, 4, 0);
  for (const float x0 : {25.0f, 25.5f, 25.123456f, 25.999f}) {
    LkPatch patch;
    ASSERT_TRUE(lk_extract(im.view(), x0, 30.3f, patch));
    float x = x0, y = 30.3f, residual;
    ASSERT_TRUE(lk_align(im.view(), patch, x, y, 5, 0.01f, residual));
    EXPECT_NEAR(x, x0, 1e-5);
    EXPECT_NEAR(y, 30.3f, 1e-4);
    EXPECT_LT(residual, 0.01f);
  }
}

}  // namespace
}  // namespace pirvs
