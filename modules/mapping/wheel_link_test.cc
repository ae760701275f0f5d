#include "modules/mapping/wheel_link.h"

#include <gtest/gtest.h>

#include "core/math/so3.h"
#include "modules/map/map_error.h"
#include "modules/state/body_state.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;

// A path as wheels would have told it, turning all the way.
WheelPath path_of(Random& random, const Vec3& b_g) {
  SE3 T_BV;
  T_BV.R = so3_exp(random.vec(0.3));
  T_BV.p = random.vec(0.5);
  WheelPath path;
  path.configure(T_BV, WheelParams{});
  Preintegration motion;
  motion.reset(b_g, Vec3::Zero());
  const Vec3 w = random.vec(0.5);
  for (int i = 0; i < 100; ++i) {
    const Mat3 before = motion.dR;
    motion.add(w, Vec3::Zero(), w, Vec3::Zero(), 0.005, ImuNoise{});
    path.turn(before, motion, 0.005);
    WheelVelocity v;
    v.forward_m_s = 1 + 0.01 * i;
    v.sigma_m_s = v.side_sigma_m_s = 0.02;
    path.speed(v, false);
  }
  path.end();
  return path;
}

TEST(wheel_link, jacobians_match_numeric) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const BodyState a = random.state(), b = random.state();
    const WheelPath path = path_of(random, a.b_g + random.vec(0.01));
    ASSERT_TRUE(path.holds());
    const WheelLink link = make_link(0, 1, path);
    const Vec3 r = link_residual(link, a, b);
    Vec3x15 J_a, J_b;
    link_jacobians(link, a, b, J_a, J_b);
    for (int k = 0; k < 15; ++k) {
      constexpr double kStep = 1e-6;
      const Vec15 step = kStep * Vec15::Unit(k);
      EXPECT_LT(((link_residual(link, boxplus(a, step), b) - r) / kStep - J_a.col(k)).norm(), 1e-4);
      EXPECT_LT(((link_residual(link, a, boxplus(b, step)) - r) / kStep - J_b.col(k)).norm(), 1e-4);
    }
  }
}

// The bundle tilts all as one without asking the wheels.
TEST(wheel_link, a_motion_of_all_as_one_changes_nothing) {
  Random random(3);
  BodyState a = random.state(), b = random.state();
  const WheelLink link = make_link(0, 1, path_of(random, a.b_g));
  const Vec3 before = link_residual(link, a, b);
  SE3 T;
  T.R = so3_exp(random.vec(0.5));
  T.p = random.vec(2);
  move(T, a);
  move(T, b);
  EXPECT_LT((link_residual(link, a, b) - before).norm(), 1e-12);
}

TEST(wheel_link, states_apart_by_the_way_have_no_residual) {
  Random random(5);
  const BodyState a = random.state();
  BodyState b = random.state();
  const WheelPath path = path_of(random, a.b_g);
  b.T_WB.p = a.T_WB * (path.way_B0 + path.p_BV) - b.T_WB.R * path.p_BV;
  EXPECT_LT(link_residual(make_link(0, 1, path), a, b).norm(), 1e-12);
}

}  // namespace
}  // namespace pirvs
