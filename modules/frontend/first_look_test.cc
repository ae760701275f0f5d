#include "modules/frontend/first_look.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

constexpr int kSide = 120;
constexpr FirstLooks::Limits kLimits{3, 8, 8, 0.03f};

// A texture about the image's centre that is turned, scaled and lit.
struct View {
  double turn = 0, scale = 1, gain = 1, x = 60, y = 60;
};

std::vector<uint8_t> draw(const testing::Texture& texture, const View& view) {
  std::vector<uint8_t> out;
  const double c = std::cos(view.turn) / view.scale, s = std::sin(view.turn) / view.scale;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const double u = column - view.x, v = row - view.y;
      const double grey = texture.at((c * u + s * v) / 10, (c * v - s * u) / 10);
      out.push_back(static_cast<uint8_t>(std::lround(std::min(255.0, view.gain * grey))));
    }
  }
  return out;
}

ImageView view_of(const std::vector<uint8_t>& pixels) {
  return {pixels.data(), kSide, kSide, kSide};
}

Track track_at(float x, float y) {
  Track track;
  track.id = 1;
  track.x = x;
  track.y = y;
  return track;
}

// The same motion by flow from image to image: what the first look is there for.
Vec2 by_flow(const std::vector<std::vector<uint8_t>>& images) {
  float x = 60, y = 60, residual;
  for (size_t i = 1; i < images.size(); ++i) {
    LkPatch patch;
    EXPECT_TRUE(lk_extract(view_of(images[i - 1]), x, y, patch));
    EXPECT_TRUE(lk_align(view_of(images[i]), patch, x, y, 8, 0.03f, residual));
  }
  return Vec2(x, y);
}

TEST(first_look, does_not_drift_where_flow_does) {
  double drift_look = 0, drift_flow = 0;
  for (uint32_t seed = 1; seed <= 10; ++seed) {
    const testing::Texture texture(seed);
    auto looks = std::make_unique<FirstLooks>();
    std::vector<std::vector<uint8_t>> images;
    Track track = track_at(60, 60);
    View view;
    for (int i = 0; i <= 60; ++i) {
      const double s = i / 60.0;
      view = {0.6 * s, 1 + 0.25 * s, 1 + 0.1 * s, 60 + 9.1 * s, 60 - 7.7 * s};
      images.push_back(draw(texture, view));
      if (i == 0) {
        looks->begin(track, view_of(images.back()));
        continue;
      }
      float residual;
      ASSERT_TRUE(looks->follow(track, view_of(images.back()), kLimits, track.x, track.y, residual))
          << seed << " " << i;
    }
    const Vec2 truth(view.x, view.y);
    drift_look += (Vec2(track.x, track.y) - truth).norm() / 10;
    drift_flow += (by_flow(images) - truth).norm() / 10;
  }
  EXPECT_LT(drift_look, 0.08);
  EXPECT_LT(drift_look, 0.5 * drift_flow);
}

TEST(first_look, refuses_what_does_not_look_like_it) {
  const testing::Texture texture(1), other(2);
  auto looks = std::make_unique<FirstLooks>();
  const auto image = draw(texture, View{}), changed = draw(other, View{});
  const auto moved = draw(texture, View{0, 1, 1, 62, 60});
  const Track track = track_at(60, 60);
  float x = 60, y = 60, residual = 0;
  EXPECT_FALSE(looks->follow(track, view_of(image), kLimits, x, y, residual)) << "never begun";
  looks->begin(track, view_of(image));
  EXPECT_FALSE(looks->follow(track, view_of(changed), kLimits, x, y, residual));
  FirstLooks::Limits near = kLimits;
  near.shift_px = 1;
  EXPECT_FALSE(looks->follow(track, view_of(moved), near, x, y, residual));
  EXPECT_EQ(x, 60);
  EXPECT_TRUE(looks->follow(track, view_of(moved), kLimits, x, y, residual));
  EXPECT_NEAR(x, 62, 0.05);
  EXPECT_NEAR(y, 60, 0.05);
}

// The slot of a track that has ended is another's by now.
TEST(first_look, is_of_one_track_alone) {
  const testing::Texture texture(1);
  auto looks = std::make_unique<FirstLooks>();
  const auto image = draw(texture, View{});
  Track track = track_at(60, 60), other = track;
  other.id = 2;
  looks->begin(track, view_of(image));
  float x = 60, y = 60, residual = 0;
  EXPECT_FALSE(looks->follow(other, view_of(image), kLimits, x, y, residual));
}

}  // namespace
}  // namespace pirvs
