#include "core/kernels/pyramid/pyramid.h"

#include <opencv2/imgproc.hpp>

#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

using testing::Image;

void expect_same(const Image& in) {
  const ImageView& view = in.view();
  const int width = (view.width + 1) / 2, height = (view.height + 1) / 2;
  Image ref(width, height, width + 3), neon(width, height, width + 3);
  pyramid_down_ref(view, ref.data(), width + 3);
  pyramid_down_neon(view, neon.data(), width + 3);
  const cv::Mat from(view.height, view.width, CV_8U, const_cast<uint8_t*>(view.data), view.stride);
  cv::Mat second;
  cv::pyrDown(from, second);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      ASSERT_EQ(ref.at(x, y), neon.at(x, y)) << x << " " << y << " of " << view.width;
      ASSERT_EQ(ref.at(x, y), second.at<uint8_t>(y, x)) << x << " " << y << " of " << view.width;
    }
}

TEST(pyramid, neon_equals_reference_and_opencv) {
  for (int content = 0; content < testing::kContents; ++content)
    for (const int height : {1, 2, 3, 4, 5, 6, 7, 16, 33})
      for (int width = 1; width < 70; ++width) {
        Image in(width, height, width + width % 3);
        fill(in, content, static_cast<uint32_t>(width));
        expect_same(in);
      }
}

TEST(pyramid, real_sizes) {
  for (const auto& [width, height] :
       {std::pair{752, 480}, {376, 240}, {188, 120}, {94, 60}, {640, 480}, {kPyramidWidthMax, 9}}) {
    Image in(width, height);
    in.fill_random(9);
    expect_same(in);
  }
}

}  // namespace
}  // namespace pirvs
