#include "modules/tracking/mm_wheel.h"

#include <gtest/gtest.h>

#include "modules/state/body_state.h"
#include "modules/testing.h"
#include "modules/tracking/filter.h"

namespace pirvs {
namespace {

using testing::Random;

SE3 vehicle(Random& random) {
  SE3 T_BV;
  T_BV.R = so3_exp(random.vec(1));
  T_BV.p = random.vec(0.5);
  return T_BV;
}

TEST(mm_wheel, jacobians_match_numeric) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const SE3 T_BV = vehicle(random);
    BodyState at = random.state();
    ImuSample sample;
    sample.w_B = random.vec(1);
    sample.f_B = random.vec(1) + Vec3(0, 0, kGravity_m_s2);
    WheelVelocity wheel;
    wheel.t = at.t;  // later by dt, its force would turn with theta: neglected, dt is below 10 ms
    wheel.dt_ns = 20'000'000;
    wheel.forward_m_s = 1;
    wheel.sigma_m_s = 0.1;
    wheel.side_sigma_m_s = 0.2;
    wheel.turn_rad_s = 0.3;
    wheel.turn_sigma_rad_s = 0.1;
    const Linear<3> speed = linearize_wheel_speed(at, sample, wheel, T_BV, 0.2);
    const Linear<1> turn = linearize_wheel_turn(at, sample, wheel, T_BV, 0.2);
    for (int k = 0; k < 15; ++k) {
      constexpr double kStep = 1e-6;
      const BodyState next = boxplus(at, kStep * Vec15::Unit(k));
      const Vec3 numeric =
          -(linearize_wheel_speed(next, sample, wheel, T_BV, 0.2).r - speed.r) / kStep;
      EXPECT_LT((numeric - speed.H.col(k)).norm(), 1e-4 * (1 + speed.H.norm())) << seed << " " << k;
      const double numeric_turn =
          -(linearize_wheel_turn(next, sample, wheel, T_BV, 0.2).r - turn.r)[0] / kStep;
      EXPECT_NEAR(numeric_turn, turn.H(0, k), 1e-4) << seed << " " << k;
    }
  }
}

TEST(mm_wheel, errors_that_stay_count_once_in_their_time) {
  EXPECT_DOUBLE_EQ(thinned(0.1, 0.2, 50'000'000), 0.2);
  EXPECT_DOUBLE_EQ(thinned(0.1, 0.2, 400'000'000), 0.1);
  EXPECT_DOUBLE_EQ(thinned(0.1, 0.2, 0), 0.1) << "the first sample";
}

// A body that goes 2 m/s forward, its filter thinking 1.5.
struct Case {
  Case() {
    BodyState state;
    state.v_WB = Vec3(1.5, 0, 0);
    Mat15 cov = 1e-6 * Mat15::Identity();
    cov.diagonal().segment<3>(kVel).setConstant(0.5 * 0.5);
    filter.configure(rig.camera, ImuNoise{}, FilterParams{});
    filter.reset(state, cov);
    filter.propagate({state.t, Vec3::Zero(), Vec3(0, 0, kGravity_m_s2)});
    wheel.dt_ns = 20'000'000;
    wheel.forward_m_s = 2;
    wheel.sigma_m_s = 0.02;
    wheel.side_sigma_m_s = 0.02;
    wheel.turn_sigma_rad_s = 0.02;
    wheel.has_turn = true;
  }
  testing::Rig rig{CameraModel::kPinholeRadtan};
  Filter filter;
  WheelVelocity wheel;
};

TEST(mm_wheel, a_speed_is_taken_and_slip_refused) {
  Case c;
  EXPECT_EQ(c.filter.update_wheel(c.wheel, SE3{}, WheelParams{}), WheelVerdict::kUsed);
  EXPECT_NEAR(c.filter.state().v_WB.x(), 2, 0.01);
  const BodyState before = c.filter.state();
  c.wheel.forward_m_s = 3.5;
  EXPECT_EQ(c.filter.update_wheel(c.wheel, SE3{}, WheelParams{}), WheelVerdict::kSlips);
  EXPECT_EQ(c.filter.state().v_WB, before.v_WB);
}

TEST(mm_wheel, wheels_that_skid_in_a_turn_still_tell_the_speed) {
  Case c;
  c.wheel.turn_rad_s = 1.0;
  EXPECT_EQ(c.filter.update_wheel(c.wheel, SE3{}, WheelParams{}), WheelVerdict::kSkids);
  EXPECT_NEAR(c.filter.state().v_WB.x(), 2, 0.01);
  EXPECT_LT(c.filter.state().b_g.norm(), 1e-4);
}

}  // namespace
}  // namespace pirvs
