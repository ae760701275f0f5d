#include "modules/matching/stereo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Texture;

// A textured wall that both cameras look at, slightly slanted: normal' p_B = distance.
struct Wall {
  Wall(CameraModel model, double distance, uint32_t texture_right = 1) : rig(model), d_m(distance) {
    rig.halve();
    for (int c = 0; c < 2; ++c) render(c, Texture(c == 0 ? 1 : texture_right));
    matcher.configure(rig.camera[0], rig.camera[1], params);
  }
  // Detail of four pixels and more at any distance.
  double unit_m() const { return 8 * d_m / rig.camera[0].fx; }
  bool hit(int c, const Vec2& uv, Vec3& p_B) const {
    Vec3 f_C;
    if (!rig.camera[c].unproject(uv, f_C)) return false;
    const SE3& T_BC = rig.camera[c].T_BC;
    const Vec3 f_B = T_BC.R * f_C;
    const double rate = normal.dot(f_B);
    if (rate < 0.1) return false;
    p_B = T_BC.p + f_B * ((d_m - normal.dot(T_BC.p)) / rate);
    return true;
  }
  void render(int c, const Texture& texture) {
    const int w = rig.camera[c].width, h = rig.camera[c].height;
    pixels[c].assign(static_cast<size_t>(w * h), 128);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        Vec3 p_B;
        if (!hit(c, Vec2(x, y), p_B)) continue;
        const double grey = texture.at(p_B.y() / unit_m(), p_B.z() / unit_m());
        pixels[c][static_cast<size_t>(y * w + x)] = static_cast<uint8_t>(std::lround(grey));
      }
    }
    build(c);
  }
  // Fields all alike, and the noise of a camera.
  void render_chequers(double field_m) {
    Random random(4);
    for (int c = 0; c < 2; ++c) {
      const size_t w = static_cast<size_t>(rig.camera[c].width);
      for (size_t i = 0; i < pixels[c].size(); ++i) {
        // A pixel is the mean of what it covers.
        double sum = 0;
        for (const Vec2& part :
             {Vec2(-0.25, -0.25), Vec2(-0.25, 0.25), Vec2(0.25, -0.25), Vec2(0.25, 0.25)}) {
          Vec3 p_B;
          if (!hit(c, Vec2(double(i % w), double(i / w)) + part, p_B)) continue;
          const double parity = std::floor(p_B.y() / field_m) + std::floor(p_B.z() / field_m);
          sum += std::fmod(std::fabs(parity), 2) == 0 ? 60 : 110;
        }
        // Lit from one side: else the histogram, which is equalized, is all noise.
        const double light = 100.0 * double(i % w) / double(w);
        pixels[c][i] = static_cast<uint8_t>(sum / 4 + light + random.uniform(-2, 2));
      }
      build(c);
    }
  }
  void build(int c) {
    const int w = rig.camera[c].width, h = rig.camera[c].height;
    store[c]->build({pixels[c].data(), w, h, w}, 3);
  }
  // Where `uv` of camera `from` lies in the other one.
  bool truth(int from, const Vec2& uv, Vec2& uv_to) const {
    Vec3 p_B;
    return hit(from, uv, p_B) && p_B.x() > 0.75 * p_B.norm() &&  // farther out it is all slant
           rig.see(SE3{}, 1 - from, p_B, uv_to);
  }
  std::vector<Vec2> grid() const {
    std::vector<Vec2> out;
    for (int y = 30; y < rig.camera[0].height - 30; y += 15) {
      for (int x = 60; x < rig.camera[0].width - 60; x += 15) out.push_back(Vec2(x + 0.3, y - 0.2));
    }
    return out;
  }
  struct Score {
    int asked = 0, found = 0, wrong = 0;
    double median_px = 1e9;
  };
  Score score(int from) {
    Score out;
    std::vector<double> errors;
    for (const Vec2& uv : grid()) {
      Vec2 expected, uv_to;
      if (!truth(from, uv, expected) || !rig.camera[1 - from].in_image(expected, 20)) continue;
      ++out.asked;
      if (matcher.find(from, *store[from], *store[1 - from], uv, uv_to) != StereoLoss::kFound) {
        continue;
      }
      ++out.found;
      errors.push_back((uv_to - expected).norm());
      if (errors.back() > 0.5) ++out.wrong;
    }
    if (errors.empty()) return out;
    std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
    out.median_px = errors[errors.size() / 2];
    return out;
  }
  uint32_t count(StereoLoss loss) const { return matcher.losses()[loss]; }

  Rig rig;
  double d_m;
  Vec3 normal = Vec3(1, 0.15, -0.1).normalized();
  StereoParams params;
  std::vector<uint8_t> pixels[2];
  std::unique_ptr<PyramidStore> store[2] = {std::make_unique<PyramidStore>(),
                                            std::make_unique<PyramidStore>()};
  StereoMatcher matcher;
};

TEST(stereo, finds_a_wall_at_any_distance_in_both_directions) {
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    for (const double distance : {1.0, 2.0, 5.0, 20.0}) {
      Wall wall(model, distance);
      for (int from = 0; from < 2; ++from) {
        const Wall::Score s = wall.score(from);
        EXPECT_GT(s.asked, 40) << distance;
        EXPECT_GT(s.found, s.asked * 6 / 10) << distance << " m, from " << from;
        EXPECT_LE(s.wrong, s.asked / 50) << distance << " m, from " << from;
        EXPECT_LT(s.median_px, 0.15) << distance << " m, from " << from;
      }
    }
  }
}

TEST(stereo, nearer_than_the_limit_is_not_found_elsewhere) {
  Wall wall(CameraModel::kPinholeRadtan, 0.7);
  wall.params.depth_m_min = 2;
  wall.matcher.configure(wall.rig.camera[0], wall.rig.camera[1], wall.params);
  const Wall::Score s = wall.score(0);
  EXPECT_LE(s.found, s.asked / 20);
}

TEST(stereo, another_scene_gives_no_match) {
  Wall wall(CameraModel::kPinholeRadtan, 2.0, 77);
  const Wall::Score s = wall.score(0);
  EXPECT_GT(s.asked, 40);
  EXPECT_LE(s.found, s.asked / 20);
}

TEST(stereo, nothing_to_see_is_no_texture) {
  Wall wall(CameraModel::kPinholeRadtan, 2.0);
  for (int c = 0; c < 2; ++c) {
    std::fill(wall.pixels[c].begin(), wall.pixels[c].end(), uint8_t{90});
    wall.build(c);
  }
  Vec2 uv_to;
  EXPECT_EQ(wall.matcher.find(0, *wall.store[0], *wall.store[1], Vec2(180, 120), uv_to),
            StereoLoss::kNoTexture);
}

TEST(stereo, a_repeated_pattern_is_ambiguous) {
  Wall wall(CameraModel::kPinholeRadtan, 2.0);
  Random random(9);
  for (int c = 0; c < 2; ++c) {
    const int w = wall.rig.camera[c].width;
    for (size_t i = 0; i < wall.pixels[c].size(); ++i) {
      const double x = static_cast<double>(i % static_cast<size_t>(w));
      const double grey = 128 + 70 * std::sin(x * 2 * M_PI / 16) + random.uniform(-6, 6);
      wall.pixels[c][i] = static_cast<uint8_t>(grey);
    }
    wall.build(c);
  }
  int ambiguous = 0, found = 0, asked = 0;
  for (const Vec2& uv : wall.grid()) {
    Vec2 uv_to;
    const StereoLoss loss = wall.matcher.find(0, *wall.store[0], *wall.store[1], uv, uv_to);
    ++asked;
    ambiguous += loss == StereoLoss::kAmbiguous ? 1 : 0;
    found += loss == StereoLoss::kFound ? 1 : 0;
  }
  EXPECT_GT(ambiguous, asked / 2);
  EXPECT_LT(found, asked / 10);
}

// The steps of the scan fall on one field as on a copy of it by chance: which of them is nearer to
// a step says nothing.
TEST(stereo, corners_of_chequers_are_ambiguous_whatever_the_step) {
  for (const double field_px : {12.0, 20.0, 30.0}) {
    Wall wall(CameraModel::kPinholeRadtan, 2.0);
    const double field_m = field_px * 2.0 / wall.rig.camera[0].fx;
    wall.render_chequers(field_m);
    int asked = 0, found = 0, wrong = 0;
    for (int i = -20; i <= 20; ++i) {
      for (int k = -20; k <= 20; ++k) {
        Vec3 p_B(0, i * field_m, k * field_m);
        p_B.x() = (wall.d_m - wall.normal.dot(p_B)) / wall.normal.x();
        Vec2 uv, expected, uv_to;
        if (!wall.rig.see(SE3{}, 0, p_B, uv) || !wall.rig.camera[0].in_image(uv, 20)) continue;
        if (!wall.rig.see(SE3{}, 1, p_B, expected)) continue;
        if (!wall.rig.camera[1].in_image(expected, 20)) continue;
        ++asked;
        const auto loss = wall.matcher.find(0, *wall.store[0], *wall.store[1], uv, uv_to);
        if (loss != StereoLoss::kFound) continue;
        ++found;
        wrong += (uv_to - expected).norm() > 3 ? 1 : 0;
      }
    }
    EXPECT_GT(asked, 40) << field_px;
    EXPECT_LE(wrong, asked / 50) << field_px << " px: " << found << " found";
  }
}

TEST(stereo, a_match_off_the_epipolar_curve_is_refused) {
  Wall wall(CameraModel::kPinholeRadtan, 2.0);
  const size_t w = static_cast<size_t>(wall.rig.camera[1].width);
  std::vector<uint8_t>& right = wall.pixels[1];
  std::copy_backward(right.begin(), right.end() - 3 * static_cast<int>(w), right.end());
  wall.build(1);
  const Wall::Score s = wall.score(0);
  EXPECT_LE(s.found, s.asked / 20);
  EXPECT_GT(wall.count(StereoLoss::kEpipolar), 0u) << "those that flow pulls to the right place";
}

TEST(stereo, find_near_refines_a_guess) {
  Wall wall(CameraModel::kKannalaBrandt, 2.0);
  Random random(5);
  int asked = 0, good = 0;
  for (const Vec2& uv : wall.grid()) {
    Vec2 expected, uv_to;
    if (!wall.truth(0, uv, expected) || !wall.rig.camera[1].in_image(expected, 20)) continue;
    ++asked;
    const StereoLoss loss = wall.matcher.find_near(0, *wall.store[0], *wall.store[1], uv,
                                                   expected + random.pixel(1.5), uv_to);
    good += loss == StereoLoss::kFound && (uv_to - expected).norm() < 0.3 ? 1 : 0;
  }
  EXPECT_GT(good, asked * 8 / 10);
}

TEST(stereo, places_at_the_rim_are_outside) {
  Wall wall(CameraModel::kPinholeRadtan, 2.0);
  const double w = wall.rig.camera[0].width, h = wall.rig.camera[0].height;
  for (const Vec2& uv : {Vec2(2, 100), Vec2(w - 2, 100), Vec2(100, 2), Vec2(100, h - 2)}) {
    Vec2 uv_to;
    EXPECT_EQ(wall.matcher.find(0, *wall.store[0], *wall.store[1], uv, uv_to),
              StereoLoss::kOutside);
  }
  EXPECT_EQ(wall.count(StereoLoss::kOutside), 4u);
}

TEST(stereo, every_question_is_counted_once) {
  Wall wall(CameraModel::kPinholeRadtan, 2.0);
  uint32_t asked = 0, sum = 0;
  for (const Vec2& uv : wall.grid()) {
    Vec2 uv_to;
    (void)wall.matcher.find(0, *wall.store[0], *wall.store[1], uv, uv_to);
    ++asked;
  }
  for (int i = 0; i < static_cast<int>(StereoLoss::kCount); ++i)
    sum += wall.matcher.losses().count[i];
  EXPECT_EQ(sum, asked);
  EXPECT_GT(wall.count(StereoLoss::kFound), asked / 2);
}

}  // namespace
}  // namespace pirvs
