#include "tools/eval/eval.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace pirvs::tools {
namespace {

constexpr char kEstimate[] = "tools/eval/testdata/estimate.tum";
constexpr char kTruth[] = "tools/eval/testdata/truth.csv";

// The lines that an evaluator written apart from this project, in numpy, prints for the same files.
TEST(eval, agrees_with_an_independent_evaluator_to_the_last_digit) {
  const Trajectory estimate = read_trajectory(kEstimate);
  const Trajectory truth = read_trajectory(kTruth);
  const auto line = [&](double delta_s) { return to_line(evaluate(estimate, truth, delta_s)); };
  const std::string ate =
      "poses 187 of 19.3 s, path 30.7 m  ATE rmse 0.0939 m std 0.0314 max 0.2105  ";
  EXPECT_EQ(line(1.0), ate + "RPE(1 s) t 0.0570 m r 1.1332 deg");
  EXPECT_EQ(line(0.5), ate + "RPE(0.5 s) t 0.0391 m r 1.1632 deg");
  EXPECT_EQ(line(3.0), ate + "RPE(3 s) t 0.1016 m r 1.1621 deg");
}

TEST(eval, rigid_motion_of_the_truth_has_no_error) {
  const Trajectory truth = read_trajectory(kTruth);
  Trajectory moved = truth;
  const Eigen::Quaterniond q_EW(Eigen::AngleAxisd(2.1, Vec3(0.3, -0.5, 0.8).normalized()));
  const Vec3 p_EW(4, -7, 2);
  for (TrajectoryPose& pose : moved.poses) {
    pose.p_WB = q_EW * pose.p_WB + p_EW;
    pose.q_WB = (q_EW * Eigen::Quaterniond(pose.q_WB)).coeffs();
  }
  const Evaluation result = evaluate(moved, truth, 1.0);
  ASSERT_TRUE(result.ok);
  EXPECT_LT(result.ate_max_m, 1e-9);
  EXPECT_LT(result.rpe_m, 1e-9);
  EXPECT_LT(result.rpe_deg, 1e-5);  // arccos near 1 halves the digits
  EXPECT_LT((result.R_WE - q_EW.conjugate().toRotationMatrix()).norm(), 1e-9);
  EXPECT_LT((result.p_WE + q_EW.conjugate() * p_EW).norm(), 1e-9);
}

TEST(eval, tilt_is_what_heading_does_not_explain) {
  const Trajectory truth = read_trajectory(kTruth);
  Trajectory turned = truth;
  const Eigen::Quaterniond heading(Eigen::AngleAxisd(2.1, Vec3::UnitZ()));
  for (TrajectoryPose& pose : turned.poses) {
    const bool late = pose.t_s - truth.poses.front().t_s > 8;
    const Eigen::Quaterniond tilt(Eigen::AngleAxisd(late ? 0.02 : 0.05, Vec3::UnitX()));
    pose.q_WB = (tilt * heading * Eigen::Quaterniond(pose.q_WB)).coeffs();
  }
  const Evaluation result = evaluate(turned, truth, 1.0);
  ASSERT_TRUE(result.ok);
  EXPECT_NEAR(result.tilt_at_10_s_deg, 0.02 * 180 / M_PI, 1e-6);
  EXPECT_NEAR(result.tilt_at_end_deg, 0.02 * 180 / M_PI, 1e-6);
  EXPECT_NEAR(result.tilt_max_deg, 0.05 * 180 / M_PI, 1e-6);
  turned.poses.erase(turned.poses.begin() + long(turned.poses.size() / 3), turned.poses.end());
  EXPECT_TRUE(std::isnan(evaluate(turned, truth, 1.0).tilt_at_10_s_deg)) << "too short";
}

TEST(eval, a_mirrored_world_is_not_aligned_by_a_mirror) {
  const Trajectory truth = read_trajectory(kTruth);
  Trajectory mirrored = truth;
  for (TrajectoryPose& pose : mirrored.poses) pose.p_WB.x() *= -1;
  const Evaluation result = evaluate(mirrored, truth, 1.0);
  ASSERT_TRUE(result.ok);
  EXPECT_GT(result.ate_rmse_m, 0.1);
  const Mat3 R = result.R_WE;
  EXPECT_NEAR(R.col(0).cross(R.col(1)).dot(R.col(2)), 1.0, 1e-9);
}

TEST(eval, a_constant_step_is_what_rpe_sees) {
  Trajectory truth;
  for (int i = 0; i < 100; ++i) {
    TrajectoryPose pose;
    pose.t = i * TimeNs{100'000'000};
    pose.t_s = double(pose.t) / 1e9;
    pose.p_WB = Vec3(0.1 * i, 0, 0);
    truth.poses.push_back(pose);
  }
  Trajectory drifting = truth;
  for (TrajectoryPose& pose : drifting.poses) pose.p_WB.y() = 0.02 * pose.t_s;
  const Evaluation result = evaluate(drifting, truth, 1.0);
  ASSERT_TRUE(result.ok);
  EXPECT_NEAR(result.rpe_m, 0.02, 1e-9);
  EXPECT_EQ(result.rpe_pairs, 88u);
}

TEST(eval, too_few_poses_is_said) {
  const Trajectory truth = read_trajectory(kTruth);
  Trajectory few;
  few.poses.assign(truth.poses.begin() + 5, truth.poses.begin() + 9);
  const Evaluation result = evaluate(few, truth, 1.0);
  EXPECT_FALSE(result.ok);
  EXPECT_EQ(to_line(result), "too few poses: 4");
}

}  // namespace
}  // namespace pirvs::tools
