#include "modules/frontend/pyramid_store.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace pirvs {
namespace {

// On the heap by itself: the address sanitizer sees a byte behind it.
void expect_held(int width, int height) {
  ASSERT_TRUE(image_fits(width, height)) << width << " x " << height;
  std::vector<uint8_t> pixels(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<uint8_t>(i * 37 >> 3);
  const auto store = std::make_unique<PyramidStore>();
  store->build({pixels.data(), width, height, width}, PyramidStore::kLevels);
  int w = width, h = height;
  const uint8_t* end = nullptr;
  for (int l = 0; l < PyramidStore::kLevels; ++l) {
    const ImageView& level = store->level(l);
    EXPECT_EQ(level.width, w);
    EXPECT_EQ(level.height, h);
    EXPECT_GE(level.stride, level.width);
    EXPECT_TRUE(end == nullptr || level.data >= end) << "levels overlap";
    end = level.row(h - 1) + w;
    w = (w + 1) / 2, h = (h + 1) / 2;
  }
  EXPECT_LE(end, reinterpret_cast<const uint8_t*>(store.get() + 1));
}

TEST(pyramid_store, holds_every_shape_within_the_limits) {
  const int side = kImageSideMax, other = kImagePixelsMax / kImageSideMax;
  expect_held(side, other);
  expect_held(other, side);
  expect_held(side - 63,
              kImagePixelsMax / (side - 63) < side ? kImagePixelsMax / (side - 63) : side);
  expect_held(side, 1);
  expect_held(1, side);
  expect_held(17, 23);
}

TEST(pyramid_store, a_host_holds_the_sensors_it_is_said_to_hold) {
  for (const auto& [width, height] : {std::pair{512, 512},
                                      {752, 480},
                                      {480, 752},
                                      {848, 800},
                                      {1280, 800},
                                      {1280, 1024},
                                      {1024, 1280}}) {
    expect_held(width, height);
  }
  EXPECT_FALSE(image_fits(1281, 800)) << "longer";
  EXPECT_FALSE(image_fits(1280, 1025)) << "more pixels";
  EXPECT_FALSE(image_fits(0, 480));
  EXPECT_FALSE(image_fits(1 << 20, 1 << 20)) << "no overflow";
}

}  // namespace
}  // namespace pirvs
