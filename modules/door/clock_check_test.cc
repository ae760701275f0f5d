#include "modules/door/clock_check.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "modules/door/door_params.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;
using Verdict = ClockCheck::Verdict;

constexpr double kFrame_s = 0.05, kImu_s = 0.005, kBegin_s = 4;

// A swaying stereo rig before a cloud of points; frames stamped t show what was at t + truth.
struct ClockCase {
  explicit ClockCase(CameraModel model, uint32_t seed) : rig(model), random(seed) {
    sway.angle_rad *= 3;
    sway.b_g = Vec3(0.02, -0.01, 0.08);
    for (int i = 0; i < 4000; ++i) points_W.push_back(random.vec(4));
    check->configure(rig.camera);
  }
  Tracks tracks(double t_s) {
    Tracks out;
    const SE3 T_WB = sway.state(t_s).T_WB, T_WB_before = sway.state(t_s - kFrame_s).T_WB;
    for (const Vec3& p_W : points_W) {
      Vec2 now, before;
      if (!rig.see(T_WB, 0, p_W, now) || !rig.see(T_WB_before, 0, p_W, before)) continue;
      now += random.pixel(0.3);
      if (random.uniform(0, 1) < outliers) now += random.pixel(20);
      Track track;
      track.x = float(now.x()), track.y = float(now.y());
      track.x_last = float(before.x()), track.y_last = float(before.y());
      track.age = 1;
      if (!out.push_back(track)) break;
    }
    return out;
  }
  // Until it is known, for a few seconds; doubt_s is the shift that is asked about.
  Verdict run(double truth_s, double doubt_s) {
    double imu_t_s = 0;
    frames = 0;
    for (double t_s = kBegin_s; t_s < kBegin_s + 4; t_s += kFrame_s) {
      for (; imu_t_s <= t_s; imu_t_s += kImu_s) {
        ImuSample sample = sway.imu(imu_t_s);
        sample.gap_s = gap_s;
        check->add_imu(sample);
      }
      const Tracks seen = tracks(t_s + truth_s);
      const TimeNs doubt = frames == 0 ? 0 : from_seconds(doubt_s);
      ++frames;
      const Verdict verdict = check->frame({from_seconds(t_s), 0, &seen, sway.b_g}, doubt);
      if (verdict != Verdict::kOpen) return verdict;
    }
    return Verdict::kOpen;
  }

  Rig rig;
  Random random;
  Sway sway;
  double outliers = 0.1;
  float gap_s = 0;
  std::vector<Vec3> points_W;
  int frames = 0;
  std::unique_ptr<ClockCheck> check = std::make_unique<ClockCheck>();
};

TEST(clock_check, tells_a_clock_that_was_set_from_stamps_that_are_right) {
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    for (uint32_t seed = 1; seed <= 3; ++seed) {
      for (const double shift_s : {-2.0, -0.5, -0.3, 0.3, 0.7}) {
        ClockCase set(model, seed);
        EXPECT_EQ(set.run(shift_s, shift_s), Verdict::kSet) << seed << ' ' << shift_s;
        EXPECT_LE(set.frames, 40 + 20 * std::max(0.0, shift_s)) << seed << ' ' << shift_s;
        ClockCase right(model, seed);
        EXPECT_EQ(right.run(0, shift_s), Verdict::kHold) << seed << ' ' << shift_s;
      }
    }
  }
}

TEST(clock_check, a_body_that_does_not_turn_says_nothing) {
  ClockCase still(CameraModel::kPinholeRadtan, 1);
  still.sway.angle_rad.setZero();
  EXPECT_EQ(still.run(0, -0.5), Verdict::kOpen);
  ClockCase set(CameraModel::kPinholeRadtan, 1);
  set.sway.angle_rad.setZero();
  EXPECT_EQ(set.run(-0.5, -0.5), Verdict::kOpen);
}

// Neither: both offsets fit badly, and nobody must conclude that the one in doubt is right.
TEST(clock_check, tracks_of_nothing_say_nothing) {
  ClockCase noise(CameraModel::kPinholeRadtan, 1);
  noise.outliers = 1;
  EXPECT_EQ(noise.run(-0.5, -0.5), Verdict::kOpen);
}

TEST(clock_check, samples_that_were_not_measured_do_not_count) {
  ClockCase bridged(CameraModel::kPinholeRadtan, 1);
  bridged.gap_s = 0.3f;
  EXPECT_EQ(bridged.run(-0.5, -0.5), Verdict::kOpen);
}

TEST(clock_check, a_shift_beyond_its_memory_stays_open) {
  ClockCase far(CameraModel::kPinholeRadtan, 1);
  EXPECT_EQ(far.run(-60, -60), Verdict::kOpen);
  EXPECT_EQ(far.run(60, 60), Verdict::kOpen);
}

TEST(clock_check, without_doubt_or_samples_nothing_is_said) {
  ClockCase none(CameraModel::kPinholeRadtan, 1);
  EXPECT_EQ(none.run(-0.5, 0), Verdict::kOpen);
  const Tracks seen = none.tracks(5);
  none.check->reset();
  EXPECT_EQ(none.check->frame({kStampMax, 0, &seen, Vec3::Zero()}, -1), Verdict::kOpen);
}

}  // namespace
}  // namespace pirvs
