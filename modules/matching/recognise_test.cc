#include "modules/matching/recognise.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;

Descriptor random_descriptor(Random& random) {
  Descriptor out{};
  for (uint64_t& word : out.w) {
    word = static_cast<uint64_t>(random.engine()) << 32 | random.engine();
  }
  return out;
}

// A map of points around a rig that has lost its place: tracks know their looks alone.
struct Case {
  explicit Case(uint32_t seed) : random(seed), rig(CameraModel::kPinholeRadtan) {
    truth.R = so3_exp(random.vec(0.4));
    truth.p = random.vec(2);
    snapshot->keyframe = 1;
    snapshot->epoch = 1;
    for (int i = 0; i < 300; ++i) add_point(i);
    look();
    view->assign(*snapshot, SE3{}, rig.camera, kCamerasMax);
    recogniser->configure(rig.camera, kCamerasMax, MatchingParams{});
  }
  void add_point(int i) {
    const double x = random.uniform(2, 8);
    const Vec3 p_B(x, random.uniform(-0.6, 0.6) * x, random.uniform(-0.4, 0.4) * x);
    MapPoint point{};
    point.id = {1, static_cast<uint16_t>(i)};
    point.p_W = truth * p_B + random.vec(0.005);
    point.descriptor = random_descriptor(random);
    point.epoch = 1;
    const Vec3 towards = truth.p - point.p_W;
    point.distance_m = static_cast<float>(towards.norm());
    point.view_W = towards.normalized();
    (void)snapshot->points.push_back(point);
  }
  void look() {
    for (int c = 0; c < kCamerasMax; ++c) {
      for (const MapPoint& point : snapshot->points) {
        Vec2 uv;
        if (!rig.see(truth, c, point.p_W, uv) || tracks[c].size() >= 60) continue;
        uv += random.pixel(0.5);
        Track track;
        track.x = static_cast<float>(uv.x());
        track.y = static_cast<float>(uv.y());
        track.described = true;
        track.descriptor = point.descriptor;
        (void)tracks[c].push_back(track);
      }
    }
  }
  // The looks of every track but each n-th become those of some other point.
  void mislead(size_t n) {
    for (Tracks& list : tracks) {
      for (size_t i = 0; i < list.size(); ++i) {
        if (i % n == 0) continue;
        const size_t other = random.engine() % snapshot->points.size();
        list[i].descriptor = snapshot->points[other].descriptor;
      }
    }
  }
  bool solve(PlaceRule rule = PlaceRule::kSame, uint32_t before = 0) {
    // The tilt is known, heading and place are not.
    const Mat3 R_WB = so3_exp(Vec3(0, 0, 2.0)) * truth.R;
    const Tracks* const lists[kCamerasMax] = {&tracks[0], &tracks[1]};
    return recogniser->solve(*view, rule, R_WB, lists, found, before);
  }
  Random random;
  Rig rig;
  SE3 truth;
  std::unique_ptr<MapSnapshot> snapshot = std::make_unique<MapSnapshot>();
  std::unique_ptr<MapView> view = std::make_unique<MapView>();
  std::unique_ptr<Recogniser> recogniser = std::make_unique<Recogniser>();
  Tracks tracks[kCamerasMax];
  Recognition found;
};

TEST(recognise, finds_heading_and_place_from_looks_alone) {
  for (uint32_t seed = 1; seed <= 10; ++seed) {
    Case c(seed);
    ASSERT_TRUE(c.solve()) << seed;
    EXPECT_LT((c.found.T_WB.p - c.truth.p).norm(), 0.02) << seed;
    EXPECT_LT(so3_log(c.truth.R.transpose() * c.found.T_WB.R).norm(), 0.01) << seed;
    EXPECT_EQ(c.found.epoch, 1);
    EXPECT_GT(c.found.matches.size(), 80u);
  }
}

TEST(recognise, a_third_of_right_matches_is_enough) {
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    Case c(20 + seed);
    c.mislead(3);
    ASSERT_TRUE(c.solve()) << seed;
    EXPECT_LT((c.found.T_WB.p - c.truth.p).norm(), 0.03) << seed;
    for (const Recognition::Match& match : c.found.matches) {
      const MapPoint& point = c.snapshot->points[match.landmark.slot];
      Vec2 uv;
      ASSERT_TRUE(c.rig.see(c.truth, match.camera, point.p_W, uv));
      const Track& track = c.tracks[match.camera][match.track];
      EXPECT_LT((uv - Vec2(track.x, track.y)).norm(), 15);
    }
  }
}

TEST(recognise, wrong_matches_make_no_place) {
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    Case c(40 + seed);
    c.mislead(1000);
    EXPECT_FALSE(c.solve()) << seed;
  }
}

TEST(recognise, looks_only_among_the_epochs_that_are_asked_for) {
  Case c(60);
  EXPECT_FALSE(c.solve(PlaceRule::kOther));
  c.snapshot->epoch = 2;
  c.view->assign(*c.snapshot, SE3{}, c.rig.camera, kCamerasMax);
  EXPECT_FALSE(c.solve(PlaceRule::kSame));
  ASSERT_TRUE(c.solve(PlaceRule::kOther));
  EXPECT_EQ(c.found.epoch, 1);
}

TEST(recognise, old_points_in_view_alone_close_a_loop) {
  Case c(65);
  c.snapshot->keyframe = 100;
  for (MapPoint& point : c.snapshot->points) point.last_keyframe = 100 - point.id.slot % 2 * 60;
  c.view->assign(*c.snapshot, c.truth, c.rig.camera, kCamerasMax);
  ASSERT_TRUE(c.solve(PlaceRule::kOld));
  EXPECT_LT((c.found.T_WB.p - c.truth.p).norm(), 0.02);
  for (const Recognition::Match& match : c.found.matches) EXPECT_EQ(match.landmark.slot % 2, 1);
  EXPECT_GT(c.found.matches.size(), 30u);
  const SE3 elsewhere{c.truth.R * so3_exp(Vec3(0, 0, 2)), c.truth.p};
  c.view->assign(*c.snapshot, elsewhere, c.rig.camera, kCamerasMax);
  EXPECT_FALSE(c.solve(PlaceRule::kOld)) << "out of view";
}

TEST(recognise, what_was_seen_before_is_looked_for_everywhere) {
  Case c(66);
  c.snapshot->keyframe = 20;
  for (MapPoint& point : c.snapshot->points) point.last_keyframe = 20 - point.id.slot % 2 * 10;
  const SE3 elsewhere{c.truth.R * so3_exp(Vec3(0, 0, 2)), c.truth.p};
  c.view->assign(*c.snapshot, elsewhere, c.rig.camera, kCamerasMax);
  EXPECT_FALSE(c.solve(PlaceRule::kBefore, 9));
  ASSERT_TRUE(c.solve(PlaceRule::kBefore, 10));
  EXPECT_LT((c.found.T_WB.p - c.truth.p).norm(), 0.02);
  for (const Recognition::Match& match : c.found.matches) EXPECT_EQ(match.landmark.slot % 2, 1);
}

TEST(recognise, is_the_same_twice) {
  Case a(70), b(70);
  a.mislead(3);
  b.mislead(3);
  ASSERT_TRUE(a.solve() && b.solve());
  EXPECT_EQ((a.found.T_WB.p - b.found.T_WB.p).norm(), 0.0);
}

}  // namespace
}  // namespace pirvs
