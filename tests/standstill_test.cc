// Rest against all that resembles it, end to end: an object sways before a device at rest, for
// PIRVS_REST_S seconds (default 12; 600 for the figure of docs/results.md); steady flights, slow
// starts, and scenes that move with the device.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/math/so3.h"
#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

double rest_seconds() {
  const char* const text = std::getenv("PIRVS_REST_S");
  return text ? std::atof(text) : 12.0;
}

tools::SimOptions options_of(const std::string& path, double duration_s) {
  tools::SimOptions options;
  options.path = path;
  options.duration_s = duration_s;
  options.blur = 1;
  options.format = "pgm";
  return options;
}

tools::SimOptions swaying(double duration_s) {
  tools::SimOptions options = options_of("rest", duration_s);
  options.mover = 0.38;
  return options;
}

tools::SimOptions steady(double duration_s, double forward_m_s, double left_m_s, double turn_deg_s,
                         double rest_s) {
  tools::SimOptions options = options_of("steady", duration_s);
  options.forward_m_s = forward_m_s;
  options.left_m_s = left_m_s;
  options.turn_deg_s = turn_deg_s;
  options.rest_s = rest_s;
  options.ramp_s = 2;
  return options;
}

struct Drift {
  double m = 0, deg = 0;  // largest, against the first pose
};

// The truth stands: what the estimate moves is its error.
Drift drift(const Replay& run) {
  Drift out;
  if (run.result.trajectory.poses.empty()) return {1e9, 1e9};
  const tools::TrajectoryPose& first = run.result.trajectory.poses.front();
  for (const tools::TrajectoryPose& pose : run.result.trajectory.poses) {
    out.m = std::max(out.m, (pose.p_WB - first.p_WB).norm());
    const double cosine = std::min(1.0, std::fabs(pose.q_WB.dot(first.q_WB)));
    const double sine = std::sqrt(1 - cosine * cosine);
    out.deg = std::max(out.deg, 2 * std::atan2(sine, cosine) * 180 / 3.14159265358979);
  }
  return out;
}

// Frames at rest in [from, until) seconds after the first frame, as a share.
double share_at_rest(const Replay& run, double from_s, double until_s) {
  double at_rest = 0, all = 0;
  for (const FrameReport& frame : run.log.frames) {
    const double t_s = to_seconds(frame.t - run.log.frames.front().t);
    if (t_s < from_s || t_s >= until_s) continue;
    all += 1;
    at_rest += frame.at_rest ? 1 : 0;
  }
  return at_rest / all;
}

void expect_no_drift(const char* what, const Replay& run) {
  print(what, run);
  const Drift d = drift(run);
  const double seconds = to_seconds(run.log.frames.back().t - run.log.frames.front().t);
  std::printf("%s: drifts by %.2f mm and %.4f deg at most, %.0f %% of the frames at rest\n", what,
              d.m * 1e3, d.deg, 100 * share_at_rest(run, 1, 1e9));
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_LE(run.first_pose_s(), 2.0);
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_EQ(run.counter("starts"), 1u);
  EXPECT_LT(d.m, 0.004 + 1e-5 * seconds);  // 10 mm and 0.1 deg after ten minutes
  EXPECT_LT(d.deg, 0.04 + 1e-4 * seconds);
}

TEST(standstill_replay, an_object_that_sways_from_the_start_moves_nothing) {
  const Replay run = replay(made(swaying(rest_seconds()), "sways"));
  expect_no_drift("an object from the start", run);
  EXPECT_GT(share_at_rest(run, 1, 1e9), 0.98);
}

TEST(standstill_replay, an_object_that_comes_in_moves_nothing) {
  tools::SimOptions options = swaying(10);
  options.mover_from_s = 3;
  options.seed = 2;
  const Replay run = replay(made(options, "comes"));
  expect_no_drift("an object that comes in", run);
  EXPECT_GT(share_at_rest(run, 1, 1e9), 0.98);
}

// What was on the object must not lead the flight that follows.
TEST(standstill_replay, a_flight_after_rest_before_an_object_is_tracked) {
  tools::SimOptions options = swaying(10);
  options.path = "spline";
  options.rest_s = 4;
  const Replay run = replay(made(options, "departs"));
  print("flight after rest before an object", run);
  EXPECT_EQ(run.result.exit_status(), 0) << run.result.verdict;
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_GT(share_at_rest(run, 1, 3.9), 0.98);
  EXPECT_EQ(share_at_rest(run, 5.5, 1e9), 0.0);
  EXPECT_LE(run.ate_of_path(), 0.01);
}

TEST(standstill_replay, a_steady_flight_is_no_rest) {
  for (const bool ahead : {false, true}) {
    const Replay run = replay(made(steady(4, ahead ? 0.1 : 0, ahead ? 0 : 0.05, 0, 0), "steady"));
    print(ahead ? "10 cm/s ahead" : "5 cm/s across", run);
    EXPECT_EQ(run.counter("standstill_frames"), 0u) << (ahead ? "ahead" : "across");
  }
}

// At rest until 2.5 s, then slowly off.
void expect_rest_ends(const char* what, const Replay& run) {
  print(what, run);
  EXPECT_GT(share_at_rest(run, 1, 2.4), 0.98);
  EXPECT_LT(share_at_rest(run, 3.7, 1e9), 0.05);
  EXPECT_LE(run.result.evaluation.ate_rmse_m, 0.01);
}

// 3 cm/s, reached over 2 s: 4 mm/s after 0.4 s.
TEST(standstill_replay, a_slow_smooth_start_ends_rest_soon) {
  expect_rest_ends("slow start", replay(made(steady(8, 0, 0.03, 0, 2.5), "creeps")));
}

TEST(standstill_replay, a_slow_turn_ends_rest_soon) {
  expect_rest_ends("slow turn", replay(made(steady(8, 0, 0, 0.5, 2.5), "turns")));
}

// The images of rest with the forces of a vehicle: shaken all the time, or setting off at 3 s with
// 0.5 m/s^2, smooth and level.
TEST(standstill_replay, a_scene_that_moves_with_the_device_is_no_rest) {
  const tools::Recording still = made(options_of("rest", 6), "vehicle");
  tools::Recording shaken = still;
  tools::Recording departing = still;
  const TimeNs begin = still.frames.front().t;
  for (size_t i = 0; i < still.imu.size(); ++i) {
    const double t_s = to_seconds(still.imu[i].t - begin);
    shaken.imu[i].f_B += Vec3(0.2, 0.4, 0.3) * std::sin(40 * t_s);
    shaken.imu[i].w_B += Vec3(0.03, 0.02, 0.01) * std::sin(25 * t_s);
    const Vec3 sideways_B = Vec3(0, 1, 0);  // of this device, level
    if (t_s > 3) departing.imu[i].f_B += 0.5 * std::min(1.0, (t_s - 3) / 0.5) * sideways_B;
  }
  EXPECT_GT(share_at_rest(replay(still), 1, 1e9), 0.98) << "without all that";
  EXPECT_EQ(replay(shaken).counter("standstill_frames"), 0u);
  const Replay run = replay(departing);
  EXPECT_GT(share_at_rest(run, 1, 3), 0.98);
  EXPECT_EQ(share_at_rest(run, 3.4, 1e9), 0.0);
}

}  // namespace
}  // namespace pirvs::systems
