// The whole stack on a real recording: EuRoC MH_01, 30 s.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

constexpr double kStandstill_s = 15;  // from here on the drone waits
constexpr double kSettled_s = 15.5;   // its last 6 mm are over

class clip_replay : public testing::Test {
 protected:
  void SetUp() override {
    if (clip() == nullptr) GTEST_SKIP() << "the real recording is not on this machine";
  }
  // Shared: a run takes seconds.
  static const Replay& one_core() {
    static const Replay run = replay(*clip());
    return run;
  }
};

// How far the error wanders from what it was at `begin`; the truth itself still settles by 6 mm.
double error_drift_m(const tools::Evaluation& evaluation, TimeNs begin) {
  bool begun = false;
  Vec3 first_m = Vec3::Zero();
  double drift_m = 0;
  for (const tools::EvalPose& pose : evaluation.matched) {
    if (pose.t < begin) continue;
    const Vec3 error_m = pose.p_WB - pose.p_truth_WB;
    if (!begun) first_m = error_m;
    begun = true;
    drift_m = std::max(drift_m, (error_m - first_m).norm());
  }
  return drift_m;
}

// How far the estimate goes from where it was at `begin`, whatever the truth says.
double distance_m(const tools::Trajectory& trajectory, TimeNs begin) {
  const tools::TrajectoryPose* first = nullptr;
  double distance_m = 0;
  for (const tools::TrajectoryPose& pose : trajectory.poses) {
    if (pose.t < begin) continue;
    if (first == nullptr) first = &pose;
    distance_m = std::max(distance_m, (pose.p_WB - first->p_WB).norm());
  }
  return distance_m;
}

TEST_F(clip_replay, starts_within_two_seconds_and_is_never_lost) {
  const Replay& run = one_core();
  print("one core", run);
  EXPECT_EQ(run.status, Status::kOk);
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_LE(run.first_pose_s(), 2.0);
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_EQ(run.result.frames_dropped, 0u);
  EXPECT_EQ(run.result.frames_tracked + run.result.frames_before_start, run.result.frames_in);
  EXPECT_EQ(run.counter("losses"), 0u);
  expect_no_failures(run);
}

TEST_F(clip_replay, is_accurate) {
  const Replay& run = one_core();
  ASSERT_TRUE(run.result.evaluation.ok);
  EXPECT_LE(run.result.evaluation.ate_rmse_m, 0.005);  // 0.0033 is reached
}

TEST_F(clip_replay, stands_still_when_the_drone_does) {
  const tools::RunResult& result = one_core().result;
  const TimeNs begin = clip()->frames.front().t;
  const double drift_m = error_drift_m(result.evaluation, begin + from_seconds(kStandstill_s));
  const double moved_m = distance_m(result.trajectory, begin + from_seconds(kSettled_s));
  std::printf("standstill: error drifts by %.1f mm, pose moves by %.1f mm once settled\n",
              drift_m * 1e3, moved_m * 1e3);
  EXPECT_LT(drift_m, 0.005);
  EXPECT_LT(moved_m, 0.005);
}

TEST_F(clip_replay, gives_the_same_bytes_again) {
  const std::string first = one_core().trajectory();
  EXPECT_TRUE(first == replay(*clip()).trajectory()) << "trajectories of two runs differ";
  EXPECT_FALSE(first.empty());
}

TEST_F(clip_replay, is_as_accurate_on_two_cores) {
  const Replay two = replay(*clip(), {2});
  print("two cores", two);
  const double one_m = one_core().result.evaluation.ate_rmse_m;
  ASSERT_TRUE(two.result.evaluation.ok);
  EXPECT_EQ(two.result.exit_status(), 0);
  EXPECT_EQ(two.result.frames_lost, 0u);
  EXPECT_LE(two.result.evaluation.ate_rmse_m, std::max(1.2 * one_m, one_m + 0.002));
}

}  // namespace
}  // namespace pirvs::systems
