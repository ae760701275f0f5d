#include "core/kernels/equalize/equalize.h"

#include <opencv2/imgproc.hpp>

#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

using testing::Image;

cv::Mat opencv(const ImageView& in) {
  const cv::Mat from(in.height, in.width, CV_8U, const_cast<uint8_t*>(in.data), in.stride);
  cv::Mat to;
  cv::equalizeHist(from, to);
  return to;
}

void expect_same(const Image& in) {
  const ImageView& view = in.view();
  const int stride = view.width + 5;
  Image ref(view.width, view.height, stride), neon(view.width, view.height, stride);
  equalize_ref(view, ref.data(), stride);
  equalize_neon(view, neon.data(), stride);
  const cv::Mat second = opencv(view);
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      ASSERT_EQ(ref.at(x, y), neon.at(x, y)) << x << " " << y << " of " << view.width;
      ASSERT_EQ(ref.at(x, y), second.at<uint8_t>(y, x)) << x << " " << y << " of " << view.width;
    }
}

TEST(equalize, neon_equals_reference_and_opencv) {
  for (int content = 0; content < testing::kContents; ++content)
    for (const int height : {1, 2, 7, 33})
      for (int width = 1; width < 70; ++width) {
        Image in(width, height, width + width % 3);
        fill(in, content, static_cast<uint32_t>(width));
        expect_same(in);
      }
}

TEST(equalize, real_size) {
  Image in(752, 480);
  in.fill([](int x, int y) { return 30 + 0.3 * testing::scene(x, y); });
  expect_same(in);
}

TEST(equalize, in_place) {
  Image in(61, 40), expected(61, 40);
  fill(in, 4, 0);
  equalize(in.view(), expected.data(), 61);
  equalize(in.view(), in.data(), 61);
  EXPECT_EQ(std::memcmp(in.data(), expected.data(), 61 * 40), 0);
}

}  // namespace
}  // namespace pirvs
