#include "core/kernels/corner/corner.h"

#include <opencv2/imgproc.hpp>

#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

using testing::Image;

void expect_same(const ImageView& im, int x0, int y0, int w, int h, float response_min) {
  Corner ref = {-1, -1, -1}, neon = {-1, -1, -1};
  ASSERT_EQ(corner_best_ref(im, x0, y0, w, h, response_min, ref),
            corner_best_neon(im, x0, y0, w, h, response_min, neon))
      << w << " x " << h;
  EXPECT_EQ(ref.x, neon.x);
  EXPECT_EQ(ref.y, neon.y);
  EXPECT_EQ(ref.response, neon.response);
}

TEST(corner, neon_equals_reference) {
  for (int content = 0; content < testing::kContents; ++content)
    for (int w = 1; w <= kCornerSizeMax; ++w) {
      const int h = content == 3 ? 1 + w * 7 % kCornerSizeMax : 1 + w % 9;
      // The rectangle and its margin fill the image, up to the last byte of memory.
      Image im(w + 2 * kCornerMargin_px, h + 2 * kCornerMargin_px,
               w + 2 * kCornerMargin_px + w % 5);
      fill(im, content, static_cast<uint32_t>(w));
      for (const float response_min : {-1.0f, 0.0f, 1.0f, 1e4f})
        expect_same(im.view(), kCornerMargin_px, kCornerMargin_px, w, h, response_min);
    }
}

TEST(corner, any_place_of_an_image) {
  Image im(160, 120);
  im.fill([](int x, int y) { return 100 + 0.3 * testing::scene(x, y) + (x * 31 + y * 17) % 7; });
  for (int i = 0; i < 60; ++i)
    expect_same(im.view(), 4 + i % 11, 4 + i % 7, 30 + i % 35, 20 + i % 45, 0.5f);
}

// Many equal corners: the first in raster order must win.
TEST(corner, ties_go_to_the_first) {
  Image im(80, 80);
  im.fill([](int x, int y) { return (x / 8 + y / 8) % 2 * 200; });
  Corner corner;
  ASSERT_TRUE(corner_best(im.view(), 8, 8, 60, 60, 1.0f, corner));
  for (int y = 8; y < 68; ++y)
    for (int x = 8; x < 68; ++x) {
      Corner single;
      if (!corner_best_ref(im.view(), x, y, 1, 1, 1.0f, single)) continue;
      EXPECT_LE(single.response, corner.response);
      if (y < corner.y || (y == corner.y && x < corner.x)) {
        EXPECT_LT(single.response, corner.response);
      }
    }
}

TEST(corner, nothing_above_the_minimum) {
  Image im(60, 60);
  im.fill([](int x, int) { return 4 * x; });
  Corner corner = {-1, -1, -1};
  EXPECT_FALSE(corner_best(im.view(), 10, 10, 40, 40, 0.01f, corner));
  EXPECT_EQ(corner.x, -1);
}

// cornerMinEigenVal scales by 1 / (255 * 4 * 5)^2 and adds 25 products; ours is their mean, with
// gradients in grey / px. It computes in float throughout: 2^-24 of the trace per operation.
TEST(corner, opencv_agrees) {
  Image im(120, 100);
  im.fill(
      [](int x, int y) { return 110 + 0.5 * (testing::scene(x, y) - 128) + (x * 7 + y * 5) % 11; });
  const cv::Mat mat(100, 120, CV_8U, im.data(), 120);
  cv::Mat response;
  cv::cornerMinEigenVal(mat, response, 5, 3);
  const double scale = std::pow(255.0 * 4 * 5, 2) / (25 * 64);
  for (int y = 10; y < 90; ++y)
    for (int x = 10; x < 110; ++x) {
      Corner corner;
      const bool found = corner_best_ref(im.view(), x, y, 1, 1, 0.0f, corner);
      EXPECT_NEAR(found ? corner.response : 0, response.at<float>(y, x) * scale, 0.01);
    }
  for (int y = 6; y < 50; y += 13) {
    Corner corner;
    ASSERT_TRUE(corner_best(im.view(), 10, y, 64, 40, 0.0f, corner));
    cv::Point best;
    cv::minMaxLoc(response(cv::Rect(10, y, 64, 40)), nullptr, nullptr, nullptr, &best);
    EXPECT_EQ(corner.x, best.x + 10);
    EXPECT_EQ(corner.y, best.y + y);
  }
}

}  // namespace
}  // namespace pirvs
