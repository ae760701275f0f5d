#include "modules/mapping/mapper.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;

constexpr double kInterval_s = 0.25;

// A way along a wall of points, seen by both cameras; each track is one point's for good.
struct Way {
  Way() : random(1), rig(CameraModel::kPinholeRadtan) {
    sway.amplitude_m = Vec3(0.2, 3.0, 0.2);
    sway.omega_rad_s.y() = 0.5;
    noise.gyro_noise = 4e-4;
    noise.accel_noise = 2e-2;
    for (int i = 0; i < 900; ++i) {
      points.push_back(
          Vec3(random.uniform(3, 5), random.uniform(-6, 6), random.uniform(-1.2, 1.2)));
    }
    mapper->configure(rig.camera, noise, MappingParams{}, ring.get(), mailbox.get());
  }
  void look(KeyframeMessage& message) {
    for (Observations& observations : message.observations) observations.clear();
    const SE3& T_WB = sway.state(to_seconds(message.state.t)).T_WB;
    for (size_t i = 0; i < points.size(); ++i) {
      Vec2 uv[kCamerasMax];
      if (!rig.see(T_WB, 0, points[i], uv[0]) || !rig.see(T_WB, 1, points[i], uv[1])) continue;
      if (message.observations[0].full()) break;
      for (int c = 0; c < kCamerasMax; ++c) {
        Observation* o = message.observations[c].append();
        *o = Observation{};
        o->track = first_track + static_cast<TrackId>(i);
        const Vec2 noisy = uv[c] + random.pixel(0.3);
        o->x = static_cast<float>(noisy.x());
        o->y = static_cast<float>(noisy.y());
        o->described = true;
        o->stereo = static_cast<int16_t>(message.observations[c].size() - 1);
      }
    }
  }
  // The next keyframe of the way, where mapping believes it to be.
  KeyframeMessage& next() {
    KeyframeMessage& message = *ring->begin_push();
    const double t_s = sent * kInterval_s + dark_s;
    message = KeyframeMessage{};
    message.sequence = ++sent;
    message.state = sway.state(t_s);
    move(T_drift, message.state);
    look(message);
    message.restart = sent == 1;
    message.linked = sent > 1;
    if (message.linked) message.from_previous = sway.between(last_s, t_s, noise);
    last_s = t_s;
    return message;
  }
  void map() {
    ring->end_push();
    for (int guard = 0; guard < 100'000 && mapper->busy(); ++guard) mapper->step();
    snapshot = mailbox->take();
  }
  const Keyframe* keyframe(uint32_t sequence) const {
    const Pool<Keyframe, kKeyframesMax>& pool = mapper->map().keyframes;
    for (size_t slot = 0; slot < pool.capacity(); ++slot) {
      const Keyframe* k = pool.at(slot);
      if (k != nullptr && k->sequence == sequence) return k;
    }
    return nullptr;
  }

  Random random;
  Rig rig;
  Sway sway;
  ImuNoise noise;
  std::vector<Vec3> points;
  SE3 T_drift;
  TrackId first_track = 1;
  uint32_t sent = 0;
  double dark_s = 0, last_s = 0;  // without keyframes so far; when the last one was
  const MapSnapshot* snapshot = nullptr;
  std::unique_ptr<KeyframeRing> ring = std::make_unique<KeyframeRing>();
  std::unique_ptr<MapMailbox> mailbox = std::make_unique<MapMailbox>();
  std::unique_ptr<Mapper> mapper = std::make_unique<Mapper>();
};

TEST(mapper, keyframes_become_less_certain_along_the_way) {
  Way way;
  for (int i = 0; i < 24; ++i) {
    way.next();
    way.map();
    ASSERT_NE(way.snapshot, nullptr);
    ASSERT_TRUE(way.snapshot->adjusted) << i;
  }
  EXPECT_LT(way.keyframe(1)->error.diagonal().tail<4>().maxCoeff(), 1e-6) << "by convention";
  const Mat6& early = way.keyframe(3)->error;
  const Mat6& late = way.keyframe(15)->error;
  EXPECT_GT(late.diagonal().tail<4>().minCoeff(), 0);
  EXPECT_GT(late(3, 3) + late(4, 4), early(3, 3) + early(4, 4));
  EXPECT_GT(late(2, 2), early(2, 2)) << "heading";
  EXPECT_LT(late(2, 2), 0.02 * 0.02);
  EXPECT_GT(way.snapshot->error(2, 2), late(2, 2)) << "what tracking hears of is the newest's";
}

TEST(mapper, a_closed_loop_moves_what_came_since_and_nothing_before) {
  Way way;
  for (int i = 0; i < 24; ++i) {
    way.next();
    way.map();
  }
  std::vector<SE3> before;
  for (uint32_t s = 1; s <= 24; ++s) before.push_back(way.keyframe(s)->state.T_WB);
  const double error_before = way.snapshot->error(2, 2);
  const uint32_t failed = way.mapper->counters().adjustments_failed;
  KeyframeMessage& message = way.next();
  message.close = true;
  message.closes_to = 5;
  message.off << 0.002, 0.01, -0.02, 0.015;
  message.off_cov = Vec4(1e-8, 1e-8, 1e-8, 1e-8).asDiagonal();
  const SE3 newest = message.state.T_WB;
  message.adjust = false;  // the correction alone
  way.map();
  way.mapper->step();
  for (uint32_t s = 1; s <= 5; ++s) {
    EXPECT_EQ(way.keyframe(s)->state.T_WB.p, before[s - 1].p) << s;
  }
  const auto moved = [&](uint32_t s) {
    return (way.keyframe(s)->state.T_WB.p - before[s - 1].p).norm();
  };
  EXPECT_LT(moved(7), 0.5 * moved(24));
  EXPECT_LT(moved(12), moved(24));
  const SE3& closed = way.keyframe(25)->state.T_WB;
  EXPECT_LT((closed.p - newest.p - Vec3(0.01, -0.02, 0.015)).norm(), 2e-3);
  EXPECT_NEAR(so3_log(closed.R * newest.R.transpose()).z(), 0.002, 2e-4);
  EXPECT_LT(way.keyframe(25)->error(2, 2), error_before) << "as certain as the old place";

  // And mapping goes on from there, in the corrected frame.
  way.T_drift = closed * way.sway.state(24 * kInterval_s).T_WB.inverse();
  way.next();
  way.map();
  ASSERT_TRUE(way.snapshot->adjusted);
  EXPECT_EQ(way.mapper->counters().adjustments_failed, failed);
  const BodyState expected = way.sway.state(25 * kInterval_s);
  const double off = (way.snapshot->state.T_WB.p - (way.T_drift * expected.T_WB).p).norm();
  EXPECT_LT(off, 0.015);  // 0.010, or 0.012 with the noise that another compiler draws
}

// Six seconds of dead reckoning, which the adjustments since then can say nothing of.
TEST(mapper, a_loop_takes_back_what_dead_reckoning_added) {
  Way way;
  for (int i = 0; i < 12; ++i) {
    way.next();
    way.map();
  }
  const Vec3 drift(0.15, -0.1, 0.05);
  way.dark_s = 6;
  way.first_track += 10000;
  way.T_drift.p = drift;
  for (int i = 0; i < 20; ++i) {
    KeyframeMessage& message = way.next();
    if (i == 0) message.drift.diagonal() << 0, 0, 1e-6, Vec3::Constant(0.2 * 0.2);
    message.linked = i > 0;
    way.map();
  }
  const Vec3 there = way.keyframe(32)->state.T_WB.p;
  KeyframeMessage& message = way.next();
  message.close = true;
  message.closes_to = 12;
  message.off << 0, -drift;
  message.off_cov = Vec4(1e-6, 1e-4, 1e-4, 1e-4).asDiagonal();
  message.adjust = false;
  way.map();
  way.mapper->step();
  const Vec3 moved = way.keyframe(32)->state.T_WB.p - there;
  EXPECT_LT((moved + drift).norm(), 0.03);
  EXPECT_LT(way.keyframe(32)->error.diagonal().tail<3>().maxCoeff(), 0.03 * 0.03);
}

// Without its IMU link, nothing determines the newest keyframe's velocity: no step is possible.
TEST(mapper, outliers_leave_the_map_even_when_the_adjustment_fails) {
  Way way;
  for (int i = 0; i < 6; ++i) {
    way.next();
    way.map();
  }
  ASSERT_EQ(way.mapper->counters().adjustments_failed, 0u);
  const uint32_t removed = way.mapper->counters().observations_removed;
  KeyframeMessage& message = way.next();
  message.linked = false;
  constexpr uint32_t kOutliers = 7;
  for (uint32_t i = 0; i < kOutliers; ++i) message.observations[0][10 * i].y += 30;
  way.map();
  EXPECT_FALSE(way.snapshot->adjusted);
  EXPECT_EQ(way.mapper->counters().adjustments_failed, 1u);
  EXPECT_GT(way.mapper->counters().observations_removed, removed + kOutliers / 2);
}

// Keyframes and points alone: no adjustment.
void send(Way& way, int keyframes) {
  for (int i = 0; i < keyframes; ++i) {
    way.next().adjust = false;
    way.map();
    way.mapper->step();
  }
}

TEST(mapper, whoever_hovers_does_not_forget_where_he_came_from) {
  Way way;
  send(way, 40);
  const uint32_t came = way.sent;
  way.sway.amplitude_m.setZero();
  way.sway.omega_rad_s.setZero();
  send(way, int(kKeyframesMax) + 200);
  EXPECT_EQ(way.mapper->map().keyframes.size(), kKeyframesMax);
  EXPECT_EQ(way.mapper->counters().keyframes_removed, 240u);
  uint32_t kept = 0;
  for (uint32_t s = 1; s <= came; ++s) kept += way.keyframe(s) != nullptr ? 1 : 0;
  EXPECT_GT(kept, came / 2);
  way.next();  // and all goes on
  way.map();
  EXPECT_TRUE(way.snapshot->adjusted);
}

TEST(mapper, what_a_removed_keyframe_added_to_the_error_stays) {
  Way way;
  for (int i = 0; i < 20; ++i) {
    way.next();
    way.map();
  }
  const auto heading_variance = [&] {
    double sum = 0;
    for (uint32_t s = 1; s <= way.sent; ++s) {
      if (const Keyframe* k = way.keyframe(s)) sum += k->added(2, 2);
    }
    return sum;
  };
  const double before = heading_variance();
  send(way, int(kKeyframesMax));
  const double of_each = way.keyframe(way.sent)->added(2, 2);  // as long as none is adjusted
  EXPECT_EQ(way.mapper->counters().keyframes_removed, 20u);
  ASSERT_GT(before, of_each);
  EXPECT_NEAR(heading_variance(), before + double(kKeyframesMax) * of_each, 1e-6 * before);
}

TEST(mapper, a_full_map_takes_new_points_and_forgets_the_weakest) {
  Way way;
  send(way, 12);
  const auto known = [&](uint32_t sequence) {
    size_t count = 0;
    for (const Observation& sighting : way.keyframe(sequence)->observations[0]) {
      count += way.mapper->map().landmarks.find(sighting.landmark) != nullptr ? 1 : 0;
    }
    return count;
  };
  const size_t known_first = known(1);
  ASSERT_GT(known_first, 100u);
  for (int wall = 0; wall < 80; ++wall) {  // always another one
    way.first_track += 1000;
    for (Vec3& point : way.points) point.y() = way.random.uniform(-6, 6);
    send(way, 2);
  }
  EXPECT_GT(way.mapper->counters().points_forgotten, 0u);
  EXPECT_EQ(way.mapper->counters().points_full, 0u);
  EXPECT_GT(known(way.sent), 100u) << "the newest";
  EXPECT_GT(known(1), known_first / 2) << "seen by many keyframes";
}

}  // namespace
}  // namespace pirvs
