#include "core/kernels/zssd/zssd.h"

#include <opencv2/core.hpp>

#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

using testing::Image;

// OpenCV's second opinion: the squared distance of the patches after their means are removed.
double opencv(const Image& a, const Image& b, int size) {
  const auto zero_mean = [size](const Image& im) {
    const ImageView& view = im.view();
    cv::Mat patch;
    cv::Mat(size, size, CV_8U, const_cast<uint8_t*>(view.data), view.stride)
        .convertTo(patch, CV_64F);
    return cv::Mat(patch - cv::mean(patch)[0]);
  };
  return cv::norm(zero_mean(a), zero_mean(b), cv::NORM_L2SQR);
}

template <class Zssd>
void expect_same(int size, Zssd ref, Zssd neon) {
  for (int ca = 0; ca < testing::kContents; ++ca)
    for (int cb = 0; cb < testing::kContents; ++cb)
      for (int pad = 0; pad < 20; pad += 3) {
        Image a(size, size, size + pad), b(size, size, size + 2 * pad);
        fill(a, ca, static_cast<uint32_t>(pad));
        fill(b, cb, static_cast<uint32_t>(100 + pad));
        const ImageView va = a.view(), vb = b.view();
        const uint32_t expected = ref(va.data, va.stride, vb.data, vb.stride);
        EXPECT_EQ(neon(va.data, va.stride, vb.data, vb.stride), expected);
        const uint8_t* last = vb.row(size - 1);  // upside down
        EXPECT_EQ(neon(va.data, va.stride, last, -vb.stride),
                  ref(va.data, va.stride, last, -vb.stride));
        const double exact = opencv(a, b, size);
        EXPECT_GE(expected, exact - 1e-6);
        EXPECT_LT(expected, exact + 1);
      }
}

TEST(zssd, neon_equals_reference_and_opencv) {
  expect_same(8, zssd_8x8_ref, zssd_8x8_neon);
  expect_same(16, zssd_16x16_ref, zssd_16x16_neon);
}

TEST(zssd, ignores_brightness) {
  Image a(16, 16), b(16, 16);
  a.fill([](int x, int y) { return 40 + 0.5 * testing::scene(x, y); });
  b.fill([&](int x, int y) { return a.at(x, y) + 37; });
  EXPECT_EQ(zssd_8x8(a.data(), 16, b.data(), 16), 0u);
  EXPECT_EQ(zssd_16x16(a.data(), 16, b.data(), 16), 0u);
  EXPECT_GT(zssd_16x16(a.data(), 16, b.data() + 16, 0), 1000u);
}

}  // namespace
}  // namespace pirvs
