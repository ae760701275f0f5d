#include "core/kernels/equalize/equalize.h"

#include <algorithm>
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

// Values that no counted row has lie between those of its neighbours.
TEST(equalize, counts_some_rows) {
  for (int content = 0; content < testing::kContents; ++content)
    for (const int every : {2, 4, 50}) {
      Image in(61, 42), ref(61, 42), neon(61, 42);
      fill(in, content, static_cast<uint32_t>(every));
      equalize_ref(in.view(), ref.data(), 61, every);
      equalize_neon(in.view(), neon.data(), 61, every);
      ASSERT_EQ(std::memcmp(ref.data(), neon.data(), 61 * 42), 0) << content << " " << every;
      int least[256], most[256];  // that a value has become
      std::fill(std::begin(least), std::end(least), 256);
      std::fill(std::begin(most), std::end(most), -1);
      for (int y = 0; y < 42; ++y)
        for (int x = 0; x < 61; ++x) {
          const int from = in.at(x, y), to = ref.at(x, y);
          least[from] = std::min(least[from], to);
          most[from] = std::max(most[from], to);
        }
      int before = 0;
      for (int v = 0; v < 256; ++v) {
        if (most[v] < 0) continue;
        EXPECT_EQ(least[v], most[v]) << v;
        EXPECT_GE(least[v], before) << v;
        before = most[v];
      }
    }
}

// Where each row stands four times, the histogram of every fourth row is that of all.
TEST(equalize, rows_that_repeat_need_not_be_counted) {
  Image in(64, 40), all(64, 40), some(64, 40);
  in.fill([](int x, int y) { return testing::scene(x, y / 4); });
  equalize(in.view(), all.data(), 64);
  equalize(in.view(), some.data(), 64, 4);
  EXPECT_EQ(std::memcmp(all.data(), some.data(), 64 * 40), 0);
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
