#include "core/kernels/lk/deform.h"

#include <cmath>
#include <cstring>

#include "core/kernels/kernel_test.h"

namespace pirvs {
namespace {

using testing::Image;

bool same(const DeformedPatch& a, const DeformedPatch& b) {
  bool factors = true;  // of the lower triangle: the rest is nobody's
  for (int i = 0; i < kDeformUnknowns; ++i)
    for (int j = 0; j <= i; ++j)
      factors &= a.factors[i * kDeformUnknowns + j] == b.factors[i * kDeformUnknowns + j];
  return factors && std::memcmp(a.lk.t, b.lk.t, sizeof a.lk.t) == 0 &&
         std::memcmp(a.lk.gx, b.lk.gx, sizeof a.lk.gx) == 0 &&
         std::memcmp(a.lk.gy, b.lk.gy, sizeof a.lk.gy) == 0 && a.mean == b.mean &&
         std::memcmp(a.sums, b.sums, sizeof a.sums) == 0 && a.lk.h_xx == b.lk.h_xx &&
         a.lk.eigenvalue_min == b.lk.eigenvalue_min;
}

Deformation random_deformation(std::mt19937& random, float size) {
  std::uniform_real_distribution<float> change(-size, size);
  return {1 + change(random), change(random), change(random), 1 + change(random),
          1 + change(random)};
}

TEST(deform, neon_equals_reference) {
  std::mt19937 random(5);
  int drawn = 0, stepped = 0;
  for (int content = 0; content < testing::kContents; ++content) {
    Image im(60, 52), other(60, 52);
    fill(im, content, 1);
    fill(other, content == 0 ? 1 : content == 1 ? 0 : content, 2);
    std::uniform_real_distribution<float> x(-1.0f, 61.0f), y(-1.0f, 53.0f);
    for (int i = 0; i < 300; ++i) {
      const float px = x(random), py = y(random);
      KeyPatch key;
      if (!key_patch(im.view(), px, py, key)) continue;
      const Deformation d = random_deformation(random, i % 2 == 0 ? 0.1f : 0.7f);
      DeformedPatch ref, neon;
      const bool ok = deform_ref(key, d, 30, ref);
      ASSERT_EQ(ok, deform_neon(key, d, 30, neon));
      if (!ok) continue;
      ++drawn;
      ASSERT_TRUE(same(ref, neon)) << px << " " << py;
      float x_ref = px, y_ref = py, x_neon = px, y_neon = py;
      Deformation d_ref = d, d_neon = d;
      const ImageView& target = i % 3 == 0 ? other.view() : im.view();
      const bool ok_step = deform_step_ref(target, ref, x_ref, y_ref, d_ref);
      ASSERT_EQ(ok_step, deform_step_neon(target, neon, x_neon, y_neon, d_neon));
      stepped += ok_step;
      EXPECT_EQ(x_ref, x_neon);
      EXPECT_EQ(y_ref, y_neon);
      EXPECT_EQ(std::memcmp(&d_ref, &d_neon, sizeof d_ref), 0);
    }
  }
  EXPECT_GT(drawn, 500);
  EXPECT_GT(stepped, 100);
}

// The largest products that a template can hold, and the largest contrast.
TEST(deform, extremes_do_not_overflow) {
  Image im(40, 40), negative(40, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) {
      im.at(x, y) = (x / 2 + y / 3) % 2 == 0 ? 255 : 0;
      negative.at(x, y) = static_cast<uint8_t>(255 - im.at(x, y));
    }
  KeyPatch key;
  ASSERT_TRUE(key_patch(im.view(), 19.5f, 19.5f, key));
  Deformation d;
  d.contrast = 1.99f;
  DeformedPatch ref, neon;
  ASSERT_TRUE(deform_ref(key, d, 30, ref));
  ASSERT_TRUE(deform_neon(key, d, 30, neon));
  EXPECT_TRUE(same(ref, neon));
  float x_ref = 19.5f, y_ref = 19.5f, x_neon = x_ref, y_neon = y_ref;
  Deformation d_ref, d_neon;
  EXPECT_EQ(deform_step_ref(negative.view(), ref, x_ref, y_ref, d_ref),
            deform_step_neon(negative.view(), neon, x_neon, y_neon, d_neon));
  EXPECT_EQ(x_ref, x_neon);
  EXPECT_EQ(d_ref.xx, d_neon.xx);
}

// A smooth scene, seen through a deformation about a point that has moved.
double scene(double x, double y) {
  return 120 + 40 * std::sin(0.45 * x + 0.2 * y) + 35 * std::cos(0.38 * y - 0.15 * x) +
         20 * std::sin(0.2 * (x + y));
}

void draw(Image& im, double cx, double cy, const Deformation& d) {
  const double area = double(d.xx) * d.yy - double(d.xy) * d.yx;
  for (int y = 0; y < im.view().height; ++y)
    for (int x = 0; x < im.view().width; ++x) {
      const double u = x - cx, v = y - cy;
      const double key_u = (d.yy * u - d.xy * v) / area, key_v = (d.xx * v - d.yx * u) / area;
      const double grey = 120 + d.contrast * (scene(key_u, key_v) - 120);
      im.at(x, y) = static_cast<uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0)));
    }
}

// Over thirty images a patch turns, grows, is sheared, gains contrast and moves: its place is still
// known to a few hundredths of a pixel, since nothing is added up.
TEST(deform, follows_without_drift) {
  constexpr int kImages = 30;
  Image first(80, 80), now(80, 80);
  draw(first, 40, 40, Deformation{});
  KeyPatch key;
  ASSERT_TRUE(key_patch(first.view(), 40, 40, key));
  Deformation found;
  float x = 40, y = 40;
  for (int i = 1; i <= kImages; ++i) {
    const float s = static_cast<float>(i) / kImages;
    const float turn = 0.5f * s, grow = 1 + 0.2f * s;
    const Deformation truth{grow * std::cos(turn), -grow * std::sin(turn) + 0.1f * s,
                            grow * std::sin(turn), grow * std::cos(turn), 1 + 0.3f * s};
    const double cx = 40 + 6.3 * s, cy = 40 - 4.7 * s;
    draw(now, cx, cy, truth);
    DeformedPatch patch;
    ASSERT_TRUE(deform(key, found, 30, patch));
    float residual;
    ASSERT_TRUE(lk_align(now.view(), patch.lk, x, y, 8, 0.02f, residual)) << i;
    ASSERT_TRUE(deform_step(now.view(), patch, x, y, found)) << i;
    EXPECT_NEAR(x, cx, 0.04) << i;
    EXPECT_NEAR(y, cy, 0.04) << i;
    EXPECT_NEAR(found.xx, truth.xx, 0.03) << i;
    EXPECT_NEAR(found.xy, truth.xy, 0.03) << i;
    EXPECT_NEAR(found.yx, truth.yx, 0.03) << i;
    EXPECT_NEAR(found.yy, truth.yy, 0.03) << i;
    EXPECT_NEAR(found.contrast, truth.contrast, 0.05) << i;
  }
}

TEST(deform, refuses_what_is_no_view_of_the_patch) {
  Image im(60, 60);
  im.fill_random(3);
  KeyPatch key;
  ASSERT_TRUE(key_patch(im.view(), 30, 30, key));
  DeformedPatch patch;
  EXPECT_TRUE(deform(key, Deformation{}, 30, patch));
  EXPECT_FALSE(deform(key, Deformation{-1, 0, 0, 1, 1}, 30, patch));       // a mirror
  EXPECT_FALSE(deform(key, Deformation{1.5f, 0, 0, 0.7f, 1}, 30, patch));  // long and thin
  EXPECT_FALSE(deform(key, Deformation{0.6f, 0, 0, 0.6f, 1}, 30, patch));  // a third of the area
  EXPECT_FALSE(deform(key, Deformation{1, 0, 0, 1, 2.5f}, 30, patch));
  EXPECT_FALSE(deform(key, Deformation{NAN, 0, 0, 1, 1}, 30, patch));
  EXPECT_FALSE(deform(key, Deformation{1, 0, 0, 1, NAN}, 30, patch));
  EXPECT_FALSE(key_patch(im.view(), NAN, 30, key));
  EXPECT_FALSE(key_patch(im.view(), -0.1f, 30, key));
  EXPECT_FALSE(key_patch(im.view(), 60, 30, key));
  float x = 3, y = 30;
  Deformation d;
  ASSERT_TRUE(deform(key, d, 30, patch));
  EXPECT_FALSE(deform_step(im.view(), patch, x, y, d));
  EXPECT_EQ(x, 3);
  EXPECT_EQ(d.xx, 1);
}

// At a corner of the image the key patch repeats the edge: no byte outside is read.
TEST(deform, key_patch_at_the_edge) {
  Image im(36, 36);
  im.fill_random(3);
  for (const float x : {0.0f, 35.9f})
    for (const float y : {0.0f, 35.9f}) {
      KeyPatch key;
      ASSERT_TRUE(key_patch(im.view(), x, y, key));
      const int row = static_cast<int>(key.y), column = static_cast<int>(key.x);
      EXPECT_EQ(key.grey[row * kKeySide + column], im.at(static_cast<int>(x), static_cast<int>(y)));
    }
}

}  // namespace
}  // namespace pirvs
