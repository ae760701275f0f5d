// One camera, none, and back: what stays true without light. Faults as --fault puts them in.
// PIRVS_MH04H: the folder of MH_04h, where it was drawn (too long to be drawn for every test).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <Eigen/LU>

#include "core/math/so3.h"
#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

using tools::Recording;

constexpr double kDark_s = 1.0;
constexpr double kChi2_max = 16.27;  // 3 dof, 99.9 %

Recording left_alone(Recording recording) {
  recording.calibration.cameras = 1;
  for (tools::FrameFiles& frame : recording.frames) frame.image[1].clear();
  return recording;
}

// ---- one camera -------------------------------------------------------------------------------

TEST(mono, simulated_flights_are_tracked_with_scale) {
  for (const SimulatedDevice device : {SimulatedDevice::kEuroc, SimulatedDevice::kIronsides}) {
    const Replay run = replay(left_alone(simulated(device)));
    print("one camera", run);
    EXPECT_EQ(run.result.exit_status(), 0);
    EXPECT_EQ(run.result.frames_lost, 0u);
    EXPECT_EQ(run.counter("camera_missing"), 0u);
    expect_no_failures(run);
    EXPECT_LE(run.ate_of_path(), 0.005);  // 0.0027 and 0.0043
  }
}

TEST(mono, the_clip_starts_in_motion_and_keeps_its_scale) {
  if (clip() == nullptr) GTEST_SKIP() << "the real recording is not on this machine";
  const Replay run = replay(left_alone(*clip()));
  print("clip, one camera", run);
  EXPECT_LE(run.first_pose_s(), 2.0);
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_EQ(run.counter("starts"), 1u);
  expect_no_failures(run);
  EXPECT_LE(run.result.evaluation.ate_rmse_m, 0.0075);  // 0.0050
}

TEST(camera_loss, the_clip_goes_on_with_either_camera) {
  if (clip() == nullptr) GTEST_SKIP() << "the real recording is not on this machine";
  const struct {
    std::vector<std::string> faults;
    double ate_m_max;
  } losses[] = {{{"cam1:5-10"}, 0.005},  // 0.0031
                {{"cam0:7-12"}, 0.005},  // 0.0034
                // Three seconds by inertia alone: 0.011 to 0.063 over seven starts.
                {{"cam1:5-10", "cam0:7-12"}, 0.06}};  // 0.0478
  for (const auto& loss : losses) {
    const Replay run = replay(*clip(), {1, loss.faults});
    print(loss.faults.front().c_str(), run);
    EXPECT_EQ(run.result.frames_lost, 0u);
    EXPECT_EQ(run.counter("losses"), 0u);
    EXPECT_GT(run.counter("keyframes"), 25u) << "one camera makes keyframes, too";
    expect_no_failures(run);
    EXPECT_LE(run.result.evaluation.ate_rmse_m, loss.ate_m_max);
  }
}

// ---- darkness ---------------------------------------------------------------------------------

struct Motion {
  double begin_s, speed_m_s, turn_rad_s;
};

// Mean motion of the truth over each stretch of kDark_s.
std::vector<Motion> motions(const Recording& recording, double from_s, double before_end_s) {
  const auto& poses = recording.truth.poses;
  const double t0_s = to_seconds(recording.frames.front().t);
  const double end_s = to_seconds(recording.frames.back().t) - t0_s - before_end_s;
  const auto at = [&](double t_s) {
    return std::lower_bound(poses.begin(), poses.end() - 1, t0_s + t_s,
                            [](const tools::TrajectoryPose& p, double t) { return p.t_s < t; });
  };
  std::vector<Motion> out;
  for (double begin_s = from_s; begin_s + kDark_s < end_s; begin_s += 0.1) {
    Motion motion{begin_s, 0, 0};
    for (auto p = at(begin_s); p + 1 < at(begin_s + kDark_s); ++p) {
      motion.speed_m_s += (p[1].p_WB - p[0].p_WB).norm() / kDark_s;
      const Mat3 turn =
          rotation_from_quat_xyzw(p[0].q_WB).transpose() * rotation_from_quat_xyzw(p[1].q_WB);
      motion.turn_rad_s += so3_log(turn).norm() / kDark_s;
    }
    out.push_back(motion);
  }
  return out;
}

// Standing, slow, fast, turning.
std::vector<Motion> four_times(const Recording& recording, double from_s, double before_end_s) {
  const std::vector<Motion> all = motions(recording, from_s, before_end_s);
  const auto by = [&](auto cost) {
    return *std::min_element(all.begin(), all.end(),
                             [&](const Motion& a, const Motion& b) { return cost(a) < cost(b); });
  };
  const Motion standing = by([](const Motion& m) { return m.speed_m_s; });
  const Motion fast = by([](const Motion& m) { return -m.speed_m_s; });
  const Motion slow =
      by([&](const Motion& m) { return std::fabs(m.speed_m_s - 0.4 * fast.speed_m_s); });
  const Motion turning = by([](const Motion& m) { return -m.turn_rad_s; });
  return {standing, slow, fast, turning};
}

// By how much the error grew from frame a to frame b, in squared sigmas of the covariance at b.
double growth_chi2(const Replay& run, size_t a, size_t b) {
  const tools::Evaluation& evaluation = run.result.evaluation;
  const auto error = [&](TimeNs t) {
    const auto pose = std::find_if(evaluation.matched.begin(), evaluation.matched.end(),
                                   [&](const tools::EvalPose& p) { return p.t == t; });
    return pose == evaluation.matched.end() ? Vec3(Vec3::Zero())
                                            : Vec3(pose->p_WB - pose->p_truth_WB);
  };
  const Vec3 e = error(run.log.frames[b].t) - error(run.log.frames[a].t);
  const Mat3 P = run.log.frames[b].pose.cov.block<3, 3>(3, 3);
  const Mat3 P_aligned = evaluation.R_WE * P * evaluation.R_WE.transpose();
  return e.dot(P_aligned.inverse() * e);
}

void expect_recovered(const Replay& run, const Motion& motion) {
  const auto& frames = run.log.frames;
  const TimeNs dark = frames.front().t + from_seconds(motion.begin_s);
  const TimeNs light = dark + from_seconds(kDark_s);
  const auto first = [&](TimeNs t) {
    size_t i = 0;
    while (i + 1 < frames.size() && frames[i].t < t) ++i;
    return i;
  };
  const size_t dark_at = first(dark), light_at = first(light);
  EXPECT_GT(frames[dark_at - 1].pose.trust.confidence, 0.5);
  EXPECT_LE(frames[dark_at].pose.trust.confidence, 0.5) << "within one frame";
  EXPECT_LT(frames[light_at - 1].pose.trust.confidence, frames[dark_at].pose.trust.confidence);
  EXPECT_LT(growth_chi2(run, dark_at - 1, light_at - 1), kChi2_max);
  size_t found = light_at;
  while (found + 1 < frames.size() && frames[found].pose.health != HealthState::kTracking) ++found;
  const double after_s = to_seconds(frames[found].t - light);
  std::printf(
      "  dark from %.1f s at %.2f m/s, %.2f rad/s: confidence %.2f to %.2f to %.2f, "
      "growth chi2 %.1f, tracking %.2f s after light\n",
      motion.begin_s, motion.speed_m_s, motion.turn_rad_s,
      double(frames[dark_at - 1].pose.trust.confidence),
      double(frames[dark_at].pose.trust.confidence),
      double(frames[light_at - 1].pose.trust.confidence),
      growth_chi2(run, dark_at - 1, light_at - 1), after_s);
  EXPECT_LE(after_s, 1.0);
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_EQ(run.counter("starts"), 1u) << "without a restart";
}

void expect_four_recoveries(const Recording& recording, double from_s, double before_end_s,
                            double slack_m) {
  const double undisturbed_m = replay(recording).result.evaluation.ate_rmse_m;
  for (const Motion& motion : four_times(recording, from_s, before_end_s)) {
    char spec[64];
    std::snprintf(spec, sizeof spec, "black:%.2f-%.2f", motion.begin_s, motion.begin_s + kDark_s);
    const Replay run = replay(recording, {1, {spec}});
    print(spec, run);
    expect_recovered(run, motion);
    EXPECT_LE(run.result.evaluation.ate_rmse_m, 1.5 * undisturbed_m + slack_m);
  }
}

TEST(blackout, a_simulated_flight_finds_itself_again) {
  expect_four_recoveries(simulated(SimulatedDevice::kEuroc), 1.5, 1.2, 0.01);
}

TEST(blackout, mh04h_finds_itself_again) {
  const char* const folder = std::getenv("PIRVS_MH04H");
  if (folder == nullptr) GTEST_SKIP() << "set PIRVS_MH04H to the folder of MH_04h";
  expect_four_recoveries(tools::open_recording(folder, {}), 5, 3, 0);
}

// ---- a true loss ------------------------------------------------------------------------------

TEST(loss, a_new_start_takes_its_place_in_the_old_map) {
  const Replay run = replay(simulated(SimulatedDevice::kEuroc), {1, {"imu:2.1-3.3"}});
  print("stream broken", run);
  EXPECT_EQ(run.counter("starts"), 2u);
  EXPECT_EQ(run.counter("joins"), 1u);
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_LE(run.ate_of_path(), 0.01) << "the path in between is not known, the place is";
  EXPECT_GT(run.log.frames.back().pose.trust.resets, 1u);
}

}  // namespace
}  // namespace pirvs::systems
