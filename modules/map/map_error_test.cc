#include "modules/map/map_error.h"

#include <gtest/gtest.h>

#include "modules/state/body_state.h"

namespace pirvs {
namespace {

BodyState some_state() {
  BodyState state;
  state.T_WB.R = so3_exp(Vec3(0.4, -0.7, 1.9));
  state.T_WB.p = Vec3(3, -2, 1);
  state.v_WB = Vec3(0.5, 1, -0.2);
  state.b_a = Vec3(0.1, -0.2, 0.05);
  return state;
}

// What the accelerometer of a body says that moves with a_W.
Vec3 force(const BodyState& state, const Vec3& a_W) {
  return state.T_WB.R.transpose() * (a_W + Vec3(0, 0, kGravity_m_s2)) + state.b_a;
}

TEST(map_error, what_turns_with_the_map_leaves_its_samples_as_they_are) {
  const BodyState state = some_state();
  const Vec3 at(1, 1, 0), a_W(0.3, -0.8, 0.2);
  constexpr double kSmall = 1e-5;
  for (int axis = 0; axis < 3; ++axis) {
    Vec6 xi = Vec6::Zero();
    xi[axis] = kSmall;
    const BodyState moved = boxplus(state, rigid_motion_under_gravity(state, at) * xi);
    const Vec3 a_turned = so3_exp(xi.head<3>()) * a_W;
    EXPECT_LT((force(moved, a_turned) - force(state, a_W)).norm(), 1e-3 * kSmall) << axis;
    // Without the bias they differ by gravity times the tilt; a turn about it does nothing.
    const BodyState biased = boxplus(state, rigid_motion(state, at) * xi);
    const double off = (force(biased, a_turned) - force(state, a_W)).norm();
    EXPECT_NEAR(off / kSmall, axis == 2 ? 0 : kGravity_m_s2, 1e-3) << axis;
  }
}

TEST(map_error, about_another_place_it_is_the_same_motion) {
  const BodyState state = some_state();
  const Vec3 from(1, 1, 0), to(-4, 2, 1);
  Mat6 root = Mat6::Identity();
  root.col(1) = (Vec6() << 0.3, 0.1, -0.2, 0.5, 0.4, -0.6).finished();
  const Mat6 cov = root * root.transpose();
  const Mat15x6 G_from = rigid_motion(state, from), G_to = rigid_motion(state, to);
  const Mat15 before = G_from * cov * G_from.transpose();
  const Mat15 after = G_to * error_about(to, from, cov) * G_to.transpose();
  EXPECT_LT((before - after).norm(), 1e-9);
}

}  // namespace
}  // namespace pirvs
