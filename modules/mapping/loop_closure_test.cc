#include "modules/mapping/loop_closure.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using Dense = Eigen::MatrixXd;

std::vector<LoopStep> walk(Random& random, int count) {
  std::vector<LoopStep> steps;
  Vec3 p = random.vec(2);
  for (int k = 0; k < count; ++k) {
    p += random.vec(0.5);
    Mat6 added = 1e-4 * random.spd<6>(1.0);
    steps.push_back({p, added});
  }
  return steps;
}

// All errors of the way as one Gaussian, conditioned on the newest's four.
TEST(loop_closure, is_the_joint_gaussian_given_the_newest) {
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const int n = 7;
    const std::vector<LoopStep> steps = walk(random, n);
    Dense joint = Dense::Zero(6 * n, 6 * n);
    for (int a = 0; a < n; ++a) {
      for (int b = 0; b < n; ++b) {
        for (int k = 0; k <= std::min(a, b); ++k) {
          const Vec3& p = steps[size_t(k)].p_WB;
          joint.block<6, 6>(6 * a, 6 * b) += motion_about(steps[size_t(a)].p_WB, p) *
                                             steps[size_t(k)].added *
                                             motion_about(steps[size_t(b)].p_WB, p).transpose();
        }
      }
    }
    const Mat4 R = 1e-5 * random.spd<4>(1.0);
    Vec4 off;
    off << random.gauss(0.01), random.vec(0.1);
    const Dense C = joint.rightCols<4>();
    const Mat4 S = joint.bottomRightCorner<4, 4>() + R;
    const Dense K = C * S.inverse();
    const Dense xi = K * off;
    const Dense left = joint - K * C.transpose();

    std::vector<LoopCorrection> out(size_t(n), LoopCorrection{});
    spread_loop(steps.data(), n, off, R, out.data());
    for (int k = 0; k < n; ++k) {
      const Vec6 expected = xi.middleRows<6>(6 * k);
      EXPECT_EQ(out[size_t(k)].xi.head<2>().norm(), 0) << "gravity knows the tilt";
      EXPECT_LT((gauge_of(out[size_t(k)].xi) - gauge_of(expected)).norm(), 1e-9) << k;
      EXPECT_LT((out[size_t(k)].left - left.block<6, 6>(6 * k, 6 * k)).norm(), 1e-12) << k;
    }
  }
}

TEST(loop_closure, equal_steps_share_a_shift_equally) {
  std::vector<LoopStep> steps;
  for (int k = 0; k < 10; ++k) {
    steps.push_back({Vec3(k, 0, 0), Mat6(Vec6::Constant(1e-6).asDiagonal())});
    steps.back().added.topLeftCorner<3, 3>().setZero();
  }
  Vec4 off;
  off << 0, 0.1, -0.2, 0.3;
  std::vector<LoopCorrection> out(10);
  spread_loop(steps.data(), 10, off, 1e-12 * Mat4::Identity(), out.data());
  for (int k = 0; k < 10; ++k) {
    const Vec3 share = 0.1 * (k + 1) * off.tail<3>();
    EXPECT_LT((out[size_t(k)].xi.tail<3>() - share).norm(), 1e-6) << k;
  }
}

TEST(loop_closure, what_is_uncertain_corrects_nothing) {
  Random random(3);
  const std::vector<LoopStep> steps = walk(random, 4);
  std::vector<LoopCorrection> out(4);
  spread_loop(steps.data(), 4, Vec4::Ones(), 1e9 * Mat4::Identity(), out.data());
  for (const LoopCorrection& correction : out) EXPECT_LT(correction.xi.norm(), 1e-9);
  spread_loop(nullptr, 0, Vec4::Ones(), Mat4::Identity(), nullptr);  // nothing since: no harm
}

TEST(loop_closure, a_motion_turns_about_its_place) {
  Vec6 xi;
  xi << 0, 0, 0.3, 0.1, 0.2, 0.3;
  const Vec3 at(4, 5, 6);
  const SE3 T = motion_of(xi, at);
  EXPECT_LT((T * at - (at + Vec3(0.1, 0.2, 0.3))).norm(), 1e-12);
  EXPECT_LT((T.R * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(so3_log(T.R).z(), 0.3, 1e-12);
}

}  // namespace
}  // namespace pirvs
