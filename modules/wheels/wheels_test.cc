#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/math/so3.h"
#include "core/math/trig.h"
#include "modules/testing.h"
#include "modules/wheels/wheel_history.h"

namespace pirvs {
namespace {

using testing::Random;

constexpr TimeNs kMs = 1'000'000;

WheelCalibration calibration() {
  WheelCalibration out;
  out.known = true;
  out.T_BV.p = Vec3(-0.2, 0.1, -0.4);
  out.track_m = 0.4;
  out.wheelbase_m = 0.5;
  out.tick_m = 0.001;
  out.time_offset_ns = 2 * kMs;
  return out;
}

WheelVelocity take(WheelOdometry& odometry, TimeNs t, WheelKind kind, double a, double b) {
  WheelVelocity out;
  EXPECT_EQ(odometry.take({t, {a, b}, kind}, out), Status::kOk);
  return out;
}

TEST(wheel_odometry, every_kind_is_a_speed_and_a_turn_rate) {
  WheelOdometry odometry;
  odometry.configure(calibration(), WheelParams{});
  WheelVelocity v = take(odometry, 100 * kMs, WheelKind::kLeftRight, 0.9, 1.1);
  EXPECT_NEAR(v.forward_m_s, 1, 1e-12);
  EXPECT_NEAR(v.turn_rad_s, 0.5, 1e-12);
  EXPECT_EQ(v.t, 102 * kMs) << "the calibration's offset";
  v = take(odometry, 110 * kMs, WheelKind::kTwist, -2, 0.25);
  EXPECT_NEAR(v.forward_m_s, -2, 1e-12);
  EXPECT_NEAR(v.turn_rad_s, 0.25, 1e-12);
  v = take(odometry, 120 * kMs, WheelKind::kSteering, 1, kPi / 4);
  EXPECT_NEAR(v.turn_rad_s, 1 / 0.5, 1e-12) << "tan(45 degrees) over the wheelbase";
}

TEST(wheel_odometry, counters_tell_a_mean_speed_in_the_middle_and_how_coarse_they_are) {
  WheelOdometry odometry;
  odometry.configure(calibration(), WheelParams{});
  WheelVelocity v;
  EXPECT_EQ(odometry.take({100 * kMs, {5000, 7000}, WheelKind::kTicks}, v), Status::kEmpty);
  v = take(odometry, 120 * kMs, WheelKind::kTicks, 5018, 7022);
  EXPECT_NEAR(v.forward_m_s, 1, 1e-9);
  EXPECT_NEAR(v.turn_rad_s, 0.004 / 0.02 / 0.4, 1e-9);
  EXPECT_EQ(v.t, (110 + 2) * kMs);
  EXPECT_GT(v.sigma_m_s, 0.41 * 0.001 / 0.02);
  EXPECT_EQ(odometry.take({900 * kMs, {6000, 8000}, WheelKind::kTicks}, v), Status::kEmpty)
      << "a gap has no mean";
}

TEST(wheel_odometry, what_cannot_be_is_refused) {
  WheelOdometry odometry;
  WheelVelocity v;
  EXPECT_EQ(odometry.take({1, {1, 1}, WheelKind::kTwist}, v), Status::kBadData) << "no calibration";
  WheelCalibration bare;
  bare.known = true;
  odometry.configure(bare, WheelParams{});
  EXPECT_EQ(odometry.take({1, {1, 1}, WheelKind::kTicks}, v), Status::kBadData) << "no tick_m";
  EXPECT_EQ(odometry.take({2, {1, 1}, WheelKind::kSteering}, v), Status::kBadData);
  odometry.configure(calibration(), WheelParams{});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(odometry.take({3, {1, nan}, WheelKind::kTwist}, v), Status::kBadData);
  EXPECT_EQ(odometry.take({4, {1000, 0}, WheelKind::kTwist}, v), Status::kBadData);
  (void)take(odometry, 10, WheelKind::kTwist, 1, 0);
  EXPECT_EQ(odometry.take({10, {1, 0}, WheelKind::kTwist}, v), Status::kStale);
}

TEST(wheel_odometry, larger_wheels_go_faster) {
  WheelOdometry odometry;
  odometry.configure(calibration(), WheelParams{});
  odometry.enlarge(0.02);
  const WheelVelocity v = take(odometry, 100 * kMs, WheelKind::kLeftRight, 0.9, 1.1);
  EXPECT_NEAR(v.forward_m_s, 1.02, 1e-12);
  EXPECT_NEAR(v.turn_rad_s, 0.51, 1e-12);
}

// A vehicle on a circle, its IMU ahead of the axle: 200 Hz samples, 50 Hz speeds.
struct Circle {
  static constexpr double kSpeed_m_s = 1.5, kTurn_rad_s = 0.8, kDuration_s = 1;
  Vec3 b_g = Vec3(0.01, -0.02, 0.03);
  ImuHistory imu;
  WheelHistory wheels;
  WheelPath begin;

  Circle() {
    WheelParams params;
    params.correlated_s = 0.2f;
    params.scale_sigma = 0.01f;
    begin.configure(calibration().T_BV, params);
    for (int k = 0; k <= 400; ++k) {
      const TimeNs t = k * 5 * kMs;
      imu.add({t, Vec3(0, 0, kTurn_rad_s) + b_g, Vec3(0, 0, kGravity_m_s2)});
      if (k % 4 != 0) continue;
      WheelVelocity v;
      v.t = t;
      v.dt_ns = 20 * kMs;
      v.forward_m_s = kSpeed_m_s;
      v.sigma_m_s = 0.02;
      v.side_sigma_m_s = 0.03;
      wheels.add({t, v, false});
    }
  }
  WheelPath path(const Vec3& bias, TimeNs t0 = 500 * kMs, TimeNs t1 = 1500 * kMs) const {
    return integrate(imu, wheels, t0, t1, bias, ImuNoise{}, begin);
  }
};

TEST(wheel_path, a_circle_is_followed_and_the_bias_told) {
  const Circle c;
  const WheelPath path = c.path(c.b_g);
  ASSERT_TRUE(path.holds());
  const double a = Circle::kTurn_rad_s * Circle::kDuration_s;
  const double r = Circle::kSpeed_m_s / Circle::kTurn_rad_s;
  EXPECT_LT((path.way_B0 - Vec3(r * std::sin(a), r * (1 - std::cos(a)), 0)).norm(), 1e-4);
  EXPECT_NEAR(path.dt_s, Circle::kDuration_s, 1e-9);
  for (int k = 0; k < 3; ++k) {
    constexpr double kStep = 1e-4;
    const Vec3 numeric = (c.path(c.b_g + kStep * Vec3::Unit(k)).way_B0 - path.way_B0) / kStep;
    EXPECT_LT((numeric - path.dway_dbg.col(k)).norm(), 0.03) << k;
  }
  // White noise of 0.02 m/s that is the same for 0.2 s, and a scale of 1 %.
  const double forward2 = 0.02 * 0.02 * 0.2, side2 = 0.03 * 0.03 * 0.2;
  EXPECT_NEAR(path.cov.trace(), forward2 + 2 * side2, 1e-6);
  EXPECT_NEAR(path.covariance().trace() - path.cov.trace(), 1e-4 * path.way_B0.squaredNorm(), 1e-9);
}

TEST(wheel_path, slip_and_gaps_are_told) {
  const Circle c;
  EXPECT_FALSE(c.path(c.b_g, 1500 * kMs, 1500 * kMs).holds()) << "no way at all";
  Circle slips;
  slips.wheels.clear();
  for (size_t i = 0; i < c.wheels.end(); ++i) {
    WheelHistory::Entry entry = c.wheels[i];
    entry.slips = entry.sample_t == 1000 * kMs;
    slips.wheels.add(entry);
  }
  EXPECT_FALSE(slips.path(c.b_g).holds());
  EXPECT_TRUE(slips.path(c.b_g, 1100 * kMs, 1500 * kMs).holds());
  Circle gap;
  gap.wheels.clear();
  for (size_t i = 0; i < c.wheels.end(); ++i) {
    const TimeNs t = c.wheels[i].sample_t;
    if (t < 800 * kMs || t > 1100 * kMs) gap.wheels.add(c.wheels[i]);
  }
  EXPECT_FALSE(gap.path(c.b_g).holds());
  Circle none;
  none.wheels.clear();
  EXPECT_FALSE(none.path(c.b_g).holds());
}

}  // namespace
}  // namespace pirvs
