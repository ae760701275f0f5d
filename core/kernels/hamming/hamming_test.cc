#include "core/kernels/hamming/hamming.h"

#include <opencv2/core.hpp>

#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

Descriptor random_descriptor(std::mt19937_64& random) {
  return {{random(), random(), random(), random()}};
}

TEST(hamming, neon_equals_reference_and_opencv) {
  std::mt19937_64 random(1);
  const Descriptor none = {}, all = {{~0ull, ~0ull, ~0ull, ~0ull}};
  EXPECT_EQ(hamming(none, all), 256);
  EXPECT_EQ(hamming(all, all), 0);
  for (int i = 0; i < 1000; ++i) {
    const Descriptor a = random_descriptor(random), b = random_descriptor(random);
    const cv::Mat ma(1, 32, CV_8U, const_cast<uint64_t*>(a.w));
    const cv::Mat mb(1, 32, CV_8U, const_cast<uint64_t*>(b.w));
    EXPECT_EQ(hamming_ref(a, b), hamming_neon(a, b));
    EXPECT_EQ(hamming_ref(a, b), static_cast<int>(cv::norm(ma, mb, cv::NORM_HAMMING)));
  }
  for (int i = 0; i < 256; ++i) {
    Descriptor one = {};
    one.w[i / 64] = uint64_t{1} << (i % 64);
    EXPECT_EQ(hamming_neon(one, none), 1);
  }
}

TEST(hamming, best_of_many) {
  std::mt19937_64 random(2);
  for (int n = 0; n < 40; ++n) {
    testing::PageEnd memory(static_cast<size_t>(n) * sizeof(Descriptor));
    Descriptor* set = reinterpret_cast<Descriptor*>(memory.data());
    for (int i = 0; i < n; ++i) {
      set[i] = random_descriptor(random);
      if (i % 5 == 4) set[i] = set[i - 2];  // ties
    }
    for (int i = 0; i < 20; ++i) {
      const Descriptor q = i < n ? set[i] : random_descriptor(random);
      int best[2], distance[2], second[2];
      hamming_best_ref(q, set, n, best[0], distance[0], second[0]);
      hamming_best_neon(q, set, n, best[1], distance[1], second[1]);
      EXPECT_EQ(best[0], best[1]);
      EXPECT_EQ(distance[0], distance[1]);
      EXPECT_EQ(second[0], second[1]);
      if (n == 0) {
        EXPECT_EQ(best[0], -1);
      }
      if (n < 2) {
        EXPECT_EQ(second[0], kHammingNone);
      }
      if (i < n) {
        EXPECT_EQ(distance[0], 0);
      }
    }
  }
}

}  // namespace
}  // namespace pirvs
