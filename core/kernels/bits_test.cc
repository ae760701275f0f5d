// The same bits on every machine: a hash of what each kernel answers on fixed random data. When a
// kernel is meant to change, the new hash is printed; x86-64 and AArch64 must print the same.
#include <cstring>

#include "core/kernels/corner/corner.h"
#include "core/kernels/describe/describe.h"
#include "core/kernels/equalize/equalize.h"
#include "core/kernels/hamming/hamming.h"
#include "core/kernels/kernel_test.h"
#include "core/kernels/lk/lk.h"
#include "core/kernels/pyramid/pyramid.h"
#include "core/kernels/zssd/zssd.h"

namespace pirvs {
namespace {

constexpr int kWidth = 752, kHeight = 480;

class Hash {  // FNV-1a
 public:
  Hash& add(const void* data, size_t size) {
    for (size_t i = 0; i < size; ++i)
      value_ = (value_ ^ static_cast<const uint8_t*>(data)[i]) * 0x100000001b3ull;
    return *this;
  }
  template <class T>
  Hash& add(const T& v) {
    return add(&v, sizeof v);
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325ull;
};

// Random blobs without libm: the same bytes on every machine. moved: by one pixel and brighter.
testing::Image blobs(bool moved) {
  testing::Image im(kWidth, kHeight);
  im.fill([](int, int) { return 90; });
  std::mt19937 random(11);
  for (int i = 0; i < 6000; ++i) {
    const int x0 = static_cast<int>(random() % (kWidth - 12)) + moved;
    const int y0 = static_cast<int>(random() % (kHeight - 12));
    const int size = 2 + static_cast<int>(random() % 10), step = static_cast<int>(random() % 120);
    for (int y = y0; y < y0 + size; ++y)
      for (int x = x0; x < x0 + size; ++x) im.at(x, y) = static_cast<uint8_t>(im.at(x, y) + step);
  }
  if (moved) {
    testing::Image brighter(kWidth, kHeight);
    brighter.fill([&](int x, int y) { return im.at(x, y) / 2 + 60; });
    return brighter;
  }
  return im;
}

// Every position is a multiple of 1/64 px and computed in integers.
float position(uint32_t random, int size_px) {
  return 24.0f + static_cast<float>(random % static_cast<uint32_t>((size_px - 48) * 64)) / 64.0f;
}

TEST(bits, equalize_and_pyramid) {
  const testing::Image in = blobs(false);
  testing::Image out(kWidth, kHeight), half(kWidth / 2, kHeight / 2);
  equalize(in.view(), out.data(), kWidth);
  pyramid_down(out.view(), half.data(), kWidth / 2);
  EXPECT_EQ(Hash().add(out.data(), kWidth * kHeight).value(), 0x26c1d0008f4dd165ull);
  EXPECT_EQ(Hash().add(half.data(), kWidth / 2 * kHeight / 2).value(), 0x6ca5004fcd85bd41ull);
}

TEST(bits, corner) {
  const testing::Image in = blobs(false);
  Hash hash;
  for (int y = 4; y + 44 <= kHeight; y += 37)
    for (int x = 4; x + 64 <= kWidth; x += 53) {
      Corner corner = {};
      hash.add(corner_best(in.view(), x, y, 60, 40, 1.0f, corner));
      hash.add(corner.x).add(corner.y).add(corner.response);
    }
  EXPECT_EQ(hash.value(), 0x907f7921c5d22bcdull);
}

TEST(bits, lk) {
  const testing::Image from = blobs(false), to = blobs(true);
  std::mt19937 random(12);
  Hash hash;
  for (int i = 0; i < 2000; ++i) {
    float x = position(random(), kWidth), y = position(random(), kHeight), residual = 0;
    LkPatch patch;
    ASSERT_TRUE(lk_extract(from.view(), x, y, patch));
    hash.add(patch.t).add(patch.gx).add(patch.gy).add(patch.sum_gx).add(patch.sum_gy);
    hash.add(patch.h_xx).add(patch.h_xy).add(patch.h_yy).add(patch.eigenvalue_min);
    hash.add(patch.x_rest_px).add(patch.y_rest_px).add(patch.usable);
    if (!patch.usable) continue;
    hash.add(lk_align(to.view(), patch, x, y, 1 + i % 10, 0.01f, residual));
    hash.add(x).add(y).add(residual);
  }
  EXPECT_EQ(hash.value(), 0x5445a506cffc5e58ull);
}

TEST(bits, describe_and_hamming) {
  const testing::Image in = blobs(false);
  constexpr float kCos[4] = {1.0f, 0.8f, -0.28f, 0.0f}, kSin[4] = {0.0f, 0.6f, 0.96f, -1.0f};
  constexpr int kPoints = 500;
  std::mt19937 random(13);
  static Descriptor descriptors[kPoints];
  Hash hash, distances;
  for (int i = 0; i < kPoints; ++i) {
    const float x = position(random(), kWidth), y = position(random(), kHeight);
    describe(in.view(), x, y, kCos[i % 4], kSin[i % 4], descriptors[i]);
    hash.add(descriptors[i]);
  }
  for (int i = 0; i < kPoints; ++i) {
    int best, distance, second;
    hamming_best(descriptors[i], descriptors, i, best, distance, second);
    distances.add(best).add(distance).add(second);
  }
  EXPECT_EQ(hash.value(), 0x3516489ce6a24978ull);
  EXPECT_EQ(distances.value(), 0xd839eed23d35e62cull);
}

TEST(bits, zssd) {
  const testing::Image a = blobs(false), b = blobs(true);
  Hash hash;
  for (int y = 0; y < kHeight - 16; y += 13)
    for (int x = 0; x < kWidth - 20; x += 7) {
      const uint8_t *pa = a.view().row(y) + x, *pb = b.view().row(y) + x + x % 5;
      hash.add(zssd_8x8(pa, kWidth, pb, kWidth)).add(zssd_16x16(pa, kWidth, pb, kWidth));
    }
  EXPECT_EQ(hash.value(), 0x83467375ec7ff1c4ull);
}

}  // namespace
}  // namespace pirvs
