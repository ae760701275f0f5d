#include "modules/output/pose_at.h"

#include <gtest/gtest.h>

namespace pirvs {
namespace {

TEST(pose_at, lies_on_the_way_from_one_to_the_other) {
  Pose a, b;
  a.state.t = 1'000'000'000;
  b.state.t = 1'005'000'000;
  const Vec3 turn(0.01, -0.02, 0.05);
  a.state.T_WB.p = Vec3(1, 2, 3);
  b.state.T_WB.p = Vec3(1.1, 2, 2.9);
  a.state.T_WB.R = so3_exp(Vec3(1, 0.5, -2));
  b.state.T_WB.R = a.state.T_WB.R * so3_exp(turn);
  b.state.v_WB = Vec3(4, 0, 0);
  b.epoch = 3;
  const Pose at = pose_at(a, b, 1'001'000'000);
  EXPECT_EQ(at.state.t, 1'001'000'000);
  EXPECT_LT((at.state.T_WB.p - Vec3(1.02, 2, 2.98)).norm(), 1e-12);
  EXPECT_LT((so3_log(a.state.T_WB.R.transpose() * at.state.T_WB.R) - 0.2 * turn).norm(), 1e-12);
  EXPECT_LT((at.state.v_WB - Vec3(0.8, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(at.epoch, 3);
  EXPECT_EQ(pose_at(a, b, a.state.t).state.T_WB.p, a.state.T_WB.p);
}

}  // namespace
}  // namespace pirvs
