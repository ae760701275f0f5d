// The whole stack on a real recording: EuRoC MH_01, 30 s.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

constexpr double kStandstill_s = 15;  // the drone stands from 14.5 s on

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

// Farthest from where it was when the standstill began.
double standstill_drift_m(const tools::Trajectory& trajectory, TimeNs begin) {
  const auto first = std::find_if(trajectory.poses.begin(), trajectory.poses.end(),
                                  [&](const auto& pose) { return pose.t >= begin; });
  double drift_m = 0;
  for (auto pose = first; pose != trajectory.poses.end(); ++pose) {
    drift_m = std::max(drift_m, (pose->p_WB - first->p_WB).norm());
  }
  return drift_m;
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
}

TEST_F(clip_replay, is_accurate) {
  const Replay& run = one_core();
  ASSERT_TRUE(run.result.evaluation.ok);
  EXPECT_LE(run.result.evaluation.ate_rmse_m, 0.020);
}

TEST_F(clip_replay, stands_still_when_the_drone_does) {
  const TimeNs begin = clip()->frames.front().t + from_seconds(kStandstill_s);
  const double drift_m = standstill_drift_m(one_core().result.trajectory, begin);
  std::printf("drift during the standstill %.1f mm\n", drift_m * 1e3);
  EXPECT_LT(drift_m, 0.005);
}

TEST_F(clip_replay, gives_the_same_bytes_again) {
  const std::string first = one_core().trajectory();
  EXPECT_TRUE(first == replay(*clip()).trajectory()) << "trajectories of two runs differ";
  EXPECT_FALSE(first.empty());
}

TEST_F(clip_replay, is_as_accurate_on_two_cores) {
  const Replay two = replay(*clip(), 2);
  print("two cores", two);
  const double one_m = one_core().result.evaluation.ate_rmse_m;
  ASSERT_TRUE(two.result.evaluation.ok);
  EXPECT_EQ(two.result.exit_status(), 0);
  EXPECT_EQ(two.result.frames_lost, 0u);
  EXPECT_LE(two.result.evaluation.ate_rmse_m, std::max(1.2 * one_m, one_m + 0.002));
}

}  // namespace
}  // namespace pirvs::systems
