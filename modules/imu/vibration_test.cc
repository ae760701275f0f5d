#include "modules/imu/vibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "modules/imu/gravity.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;

constexpr double kRate_hz = 200;

// Three seconds: `sigma` of white noise and a tone of `amplitude` on each axis, of both sensors
// alike, on a motion of the body of `motion` at 1 Hz.
VibrationMeter shaken(double sigma, double amplitude, double tone_hz, double motion = 0) {
  VibrationMeter meter;
  Random random{3};
  for (int i = 0; i < 600; ++i) {
    const double t_s = i / kRate_hz;
    const Vec3 tone = Vec3::Constant(amplitude * std::sin(2 * M_PI * tone_hz * t_s) +
                                     motion * std::sin(2 * M_PI * t_s));
    ImuSample sample;
    sample.t = from_seconds(t_s);
    sample.w_B = random.vec(sigma) + tone;
    sample.f_B = random.vec(sigma) + tone + Vec3(0, 0, kGravity_m_s2);
    meter.add(sample);
  }
  return meter;
}

TEST(vibration, white_noise_has_its_density) {
  const VibrationMeter meter = shaken(2, 0, 0);
  const double density = 2 / std::sqrt(kRate_hz);
  EXPECT_NEAR(meter.gyro_density() / density, 1, 0.35);  // of twelve means
  EXPECT_NEAR(meter.accel_density() / density, 1, 0.35);
}

// A tone does not walk: of 10 m/s^2 at 87 Hz an integral keeps 0.02 m/s.
TEST(vibration, a_tone_counts_less_than_noise_of_its_size) {
  const double white = 10 / std::sqrt(2) / std::sqrt(kRate_hz);
  EXPECT_LT(shaken(0, 10, 87).accel_density(), 0.35 * white);
}

TEST(vibration, motion_is_none) {
  EXPECT_LT(shaken(0, 0, 0, 3).accel_density(), 0.02);
  const VibrationMeter calm = shaken(0.03, 0, 0, 3);
  const ImuNoise noise;
  EXPECT_EQ(calm.on_top_of(noise).gyro_noise, noise.gyro_noise);
  EXPECT_EQ(calm.on_top_of(noise).accel_noise, noise.accel_noise);
}

TEST(vibration, noise_grows_by_what_is_unusual) {
  const ImuNoise noise;
  const VibrationMeter meter = shaken(5, 0, 0);
  const ImuNoise out = meter.on_top_of(noise);
  EXPECT_NEAR(out.accel_noise, meter.accel_density(), 0.1 * meter.accel_density());
  EXPECT_NEAR(out.gyro_noise, meter.gyro_density(), 0.1 * meter.gyro_density());
  EXPECT_EQ(out.gyro_walk, noise.gyro_walk);
  EXPECT_EQ(out.accel_walk, noise.accel_walk);
}

TEST(vibration, says_nothing_after_a_gap) {
  VibrationMeter meter = shaken(5, 0, 0);
  ImuSample sample;
  sample.t = from_seconds(4);
  sample.gap_s = 1;
  sample.f_B = Vec3(300, 0, 0);
  meter.add(sample);
  EXPECT_EQ(meter.accel_density(), 0);
}

}  // namespace
}  // namespace pirvs
