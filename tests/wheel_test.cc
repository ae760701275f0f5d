// Wheels in tracking and mapping, through the whole stack: where cameras and IMU do not suffice.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/math/so3.h"
#include "core/math/trig.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/dataset/wheel_file.h"

namespace pirvs::systems {
namespace {

tools::SimOptions drive(const std::string& path, double duration_s) {
  tools::SimOptions options;
  options.path = path;
  options.duration_s = duration_s;
  options.wheels.kind = "left_right";
  options.blur = 1;
  options.format = "jpg";
  return options;
}

tools::Recording without_wheels(tools::Recording recording) {
  recording.wheels.clear();
  recording.calibration.wheels.known = false;
  return recording;
}

// How far the run has gone between two times, over the truth; and how far off it is at the second
// when both agree at the first.
struct Way {
  double scale, error_m, way_m, turn_error_rad;
};
Way way_between(const Replay& run, const tools::Recording& recording, double from_s, double to_s) {
  const auto& frames = run.log.frames;
  const TimeNs begin = recording.frames.front().t;
  const auto pose_at = [&](double s) {
    return *std::find_if(frames.begin(), frames.end(), [&](const FrameReport& frame) {
      return frame.has_pose && frame.t >= begin + from_seconds(s);
    });
  };
  const auto truth_at = [&](TimeNs t) {
    const auto& truth = recording.truth.poses;
    const auto at = std::lower_bound(truth.begin(), truth.end(), t,
                                     [](const auto& p, TimeNs time) { return p.t < time; });
    return SE3{rotation_from_quat_xyzw(at->q_WB), at->p_WB};
  };
  const FrameReport a = pose_at(from_s), b = pose_at(to_s);
  const SE3 is = a.pose.state.T_WB.inverse() * b.pose.state.T_WB;
  const SE3 was = truth_at(a.t).inverse() * truth_at(b.t);
  return {is.p.norm() / was.p.norm(), (is.p - was.p).norm(), was.p.norm(),
          so3_log(is.R.transpose() * was.R).norm()};
}

// At constant speed an accelerometer says nothing of how large it is.
TEST(wheels, one_camera_at_constant_speed_has_a_scale) {
  tools::Recording recording = made(drive("straight", 9), "wheels_straight");
  recording.calibration.cameras = 1;
  const Replay run = replay(recording), alone = replay(without_wheels(recording));
  ASSERT_GT(run.result.frames_tracked, 100u);
  const Way way = way_between(run, recording, 1.5, 8.5);
  std::printf("one camera at 1 m/s: scale %.4f; without wheels %zu frames tracked\n", way.scale,
              alone.result.frames_tracked);
  EXPECT_NEAR(way.scale, 1, 0.01);
  EXPECT_EQ(alone.result.frames_tracked, 0u) << "it would have to guess";
  EXPECT_EQ(run.counter("wheels_refused"), 0u);
  EXPECT_EQ(run.counter("wheels_slipping"), 0u);
}

// Ten seconds of darkness, in which a wheel spins.
TEST(wheels, a_blind_drive_goes_where_the_wheels_roll) {
  tools::SimOptions options = drive("ramps", 17);
  options.dark = 1;
  options.dark_from_s = 5;
  options.dark_for_s = 10;
  const tools::Recording recording = made(options, "wheels_blind");
  const Replay run = replay(recording), alone = replay(without_wheels(recording));
  const Way way = way_between(run, recording, 4.9, 14.9);
  const Way free = way_between(alone, recording, 4.9, 14.9);
  std::printf("10 s blind: %.3f of %.1f m off (%.2f %%), without wheels %.3f\n", way.error_m,
              way.way_m, 100 * way.error_m / way.way_m, free.error_m);
  EXPECT_LT(way.error_m, 0.02 * way.way_m);
  EXPECT_LT(way.error_m, 0.5 * free.error_m);
  EXPECT_EQ(run.counter("losses"), 0u);
}

TEST(wheels, a_wheel_that_spins_is_refused) {
  tools::SimOptions options = drive("ramps", 12);
  options.wheels.spin_m_s = 1.5;
  options.wheels.spin_from_s = 7;
  options.wheels.spin_for_s = 2;
  const tools::Recording recording = made(options, "wheels_spin");
  const Replay run = replay(recording);
  const Way way = way_between(run, recording, 3, 11);
  print("a wheel spins for 2 s", run);
  EXPECT_LT(way.error_m, 0.1);
  EXPECT_GE(run.counter("wheels_slipping"), 100u) << "50 a second";
  EXPECT_LT(run.counter("wheels_slipping"), 150u);
}

TEST(wheels, turning_on_the_spot_ten_times_stays_there) {
  tools::SimOptions options = drive("spot", 66);
  options.rate_hz = 10;
  options.wheels.kind = "ticks";
  const tools::Recording recording = made(options, "wheels_spot");
  const Replay run = replay(recording);
  const Way way = way_between(run, recording, 1.5, 65);
  std::printf("ten turns: %.4f m, %.3f degrees\n", way.error_m, way.turn_error_rad * 180 / kPi);
  EXPECT_LT(way.error_m, 0.1);
  EXPECT_LT(way.turn_error_rad, kPi / 180);
}

// Tyres that are 3 % smaller than the calibration says are told, and corrected if asked for.
TEST(wheels, a_wrong_radius_is_told_and_estimated) {
  tools::SimOptions options = drive("ramps", 40);
  options.rate_hz = 10;
  options.wheels.scale = 1.03;
  const tools::Recording recording = made(options, "wheels_scale");
  const Replay told = replay(recording);
  std::printf("wheels 3 %% too fast: %+.4f seen, sigma %.4f\n", told.log.calibration.scale,
              told.log.calibration.scale_sigma);
  EXPECT_NE(told.log.calibration_news[2].find("% smaller"), std::string::npos)
      << told.log.calibration_news[2];
  ReplayOptions how;
  how.estimate_wheels = true;
  const Replay corrected = replay(recording, how);
  std::printf("corrected by %.4f, ATE %.4f to %.4f m\n", corrected.log.wheel_scale,
              told.result.evaluation.ate_rmse_m, corrected.result.evaluation.ate_rmse_m);
  EXPECT_NEAR(corrected.log.wheel_scale, 1 / 1.03, 0.01);
  EXPECT_TRUE(corrected.log.calibration_news[2].empty());
}

}  // namespace
}  // namespace pirvs::systems
