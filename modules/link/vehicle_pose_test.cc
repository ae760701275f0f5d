#include "modules/link/vehicle_pose.h"

#include <gtest/gtest.h>

#include "modules/testing.h"

namespace pirvs {
namespace {

Pose random_pose(testing::Random& random) {
  Pose pose;
  pose.state = random.state();
  pose.w_B = random.vec(1);
  Mat9 root;
  for (int i = 0; i < 81; ++i) root(i / 9, i % 9) = random.gauss(0.03);
  pose.cov = root * root.transpose() + 1e-4 * Mat9::Identity();
  return pose;
}

TEST(vehicle_pose, z_points_down_and_forward_stays) {
  Pose pose;
  pose.state.T_WB.p = Vec3(1, 2, 3);
  pose.state.T_WB.R = so3_exp(Vec3(0, 0, 0.5));  // a turn to the left
  pose.state.v_WB = pose.state.T_WB.R * Vec3(2, 0.5, 0.25);
  pose.w_B = Vec3(0.1, 0.2, 0.3);
  const VehiclePose out = vehicle_pose(pose, Mat3::Identity());
  EXPECT_LT((out.p_LD - Vec3(1, -2, -3)).norm(), 1e-12);
  EXPECT_LT((roll_pitch_yaw(out.R_LD) - Vec3(0, 0, -0.5)).norm(), 1e-12) << "clockwise from above";
  EXPECT_LT((out.v_D - Vec3(2, -0.5, -0.25)).norm(), 1e-12);
  EXPECT_LT((out.w_D - Vec3(0.1, -0.2, -0.3)).norm(), 1e-12);
  // Both frames are turned over: w, x, -y, -z.
  const Vec4 q_WB = quat_xyzw(pose.state.T_WB.R), q_LD = quat_xyzw(out.R_LD);
  EXPECT_LT((q_LD - Vec4(q_WB(0), -q_WB(1), -q_WB(2), q_WB(3))).norm(), 1e-12);
}

TEST(vehicle_pose, how_the_imu_is_mounted_changes_the_vehicle_alone) {
  testing::Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Vec3 angles(random.uniform(-3, 3), random.uniform(-1.5, 1.5), random.uniform(-3, 3));
    const Mat3 R_VB = mounting(angles);
    EXPECT_LT((roll_pitch_yaw(R_VB) - angles).norm(), 1e-9);
    Pose vehicle = random_pose(random), imu = vehicle;  // the same motion, seen by turned axes
    imu.state.T_WB.R = vehicle.state.T_WB.R * R_VB;
    imu.w_B = R_VB.transpose() * vehicle.w_B;
    Mat9 turn = Mat9::Identity();
    turn.topLeftCorner<3, 3>() = R_VB.transpose();
    imu.cov = turn * vehicle.cov * turn.transpose();
    const VehiclePose a = vehicle_pose(vehicle, Mat3::Identity()), b = vehicle_pose(imu, R_VB);
    EXPECT_LT((a.R_LD - b.R_LD).norm(), 1e-9);
    EXPECT_LT((a.v_D - b.v_D).norm(), 1e-9);
    EXPECT_LT((a.w_D - b.w_D).norm(), 1e-9);
    EXPECT_LT((a.cov_pose - b.cov_pose).norm(), 1e-9);
    EXPECT_LT((a.cov_v_D - b.cov_v_D).norm(), 1e-9);
  }
}

// The error of each number that is sent, from that of the state, by differences.
TEST(vehicle_pose, covariances_match_numeric_propagation) {
  testing::Random random(11);
  for (int round = 0; round < 100; ++round) {
    const Pose pose = random_pose(random);
    const Mat3 R_VB = mounting(random.vec(1));
    const VehiclePose out = vehicle_pose(pose, R_VB);
    constexpr double kStep = 1e-6;
    Eigen::Matrix<double, 6, 9> J;
    Eigen::Matrix<double, 3, 9> J_v_D, J_v_L;
    for (int k = 0; k < 9; ++k) {
      Vec15 delta = Vec15::Zero();
      delta(k) = kStep;
      Pose plus = pose, minus = pose;
      plus.state = boxplus(pose.state, delta);
      minus.state = boxplus(pose.state, -delta);
      const VehiclePose a = vehicle_pose(plus, R_VB), b = vehicle_pose(minus, R_VB);
      J.block<3, 1>(0, k) = (a.p_LD - b.p_LD) / (2 * kStep);
      J.block<3, 1>(3, k) = so3_log(a.R_LD * b.R_LD.transpose()) / (2 * kStep);
      J_v_D.col(k) = (a.v_D - b.v_D) / (2 * kStep);
      J_v_L.col(k) = (a.v_LD - b.v_LD) / (2 * kStep);
    }
    EXPECT_LT((out.cov_pose - J * pose.cov * J.transpose()).norm(), 1e-7);
    EXPECT_LT((out.cov_v_D - J_v_D * pose.cov * J_v_D.transpose()).norm(), 1e-7);
    EXPECT_LT((out.cov_v_LD - J_v_L * pose.cov * J_v_L.transpose()).norm(), 1e-7);
  }
}

}  // namespace
}  // namespace pirvs
