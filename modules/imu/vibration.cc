#include "modules/imu/vibration.h"

#include <cmath>

#include "core/math/square.h"

namespace pirvs {
namespace {

constexpr TimeNs kBlock = 20'000'000;
constexpr double kGain = 1.0 / 12;  // a quarter of a second
constexpr int kBlocks = 6;
// Multirotors that fly well have up to this: 0.1 rad/s and 1.5 m/s^2 at 200 Hz.
constexpr double kUsualGyro = 0.007, kUsualAccel = 0.1;
constexpr double kAxes = 3, kSecondDifference = 1.5;

double raised(double density, double measured2, double usual) {
  const double excess = measured2 - square(usual);
  return excess > 0 ? std::sqrt(square(density) + excess) : density;
}

}  // namespace

void VibrationMeter::add(const ImuSample& sample) {
  if (samples_ == 0) begin_ = sample.t;
  if (sample.gap_s > 0) {  // what lies before says nothing of what comes
    blocks_ = samples_ = 0;
    sum_ = {};
    begin_ = sample.t;
  }
  if (samples_ > 0 && sample.t - begin_ >= kBlock) close(to_seconds(sample.t - begin_));
  if (samples_ == 0) begin_ = sample.t;
  sum_.w_B += sample.w_B;
  sum_.f_B += sample.f_B;
  ++samples_;
}

void VibrationMeter::close(double duration_s) {
  const Block mean{sum_.w_B / samples_, sum_.f_B / samples_};
  sum_ = {};
  samples_ = 0;
  if (++blocks_ > 2) {
    const Vec3 w = last_.w_B - 0.5 * (mean.w_B + before_last_.w_B);
    const Vec3 f = last_.f_B - 0.5 * (mean.f_B + before_last_.f_B);
    const double scale = duration_s / (kSecondDifference * kAxes);
    gyro2_ += kGain * (scale * w.squaredNorm() - gyro2_);
    accel2_ += kGain * (scale * f.squaredNorm() - accel2_);
  }
  before_last_ = last_;
  last_ = mean;
}

double VibrationMeter::gyro_density() const { return blocks_ < kBlocks ? 0 : std::sqrt(gyro2_); }
double VibrationMeter::accel_density() const { return blocks_ < kBlocks ? 0 : std::sqrt(accel2_); }

ImuNoise VibrationMeter::on_top_of(const ImuNoise& noise) const {
  ImuNoise out = noise;
  if (blocks_ < kBlocks) return out;
  out.gyro_noise = raised(noise.gyro_noise, gyro2_, kUsualGyro);
  out.accel_noise = raised(noise.accel_noise, accel2_, kUsualAccel);
  return out;
}

}  // namespace pirvs
