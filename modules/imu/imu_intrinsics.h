// Deterministic errors of an IMU, scale, misalignment and bias: measured = matrix * true + bias,
// for the gyro and the accelerometer each.
// In      matrices with scale on the diagonal, misalignment beside it; a sample as measured.
// Out     apply(): the sample without these errors. How biases have changed since the calibration,
//         the filter estimates.
// Frames  B: axes and place of the accelerometer.
// Units   rad/s, m/s^2.
// Errors  none: nothing is touched, to the bit, unless something is given.
// Cost    ~20 ns a sample.
// Source  Rehder, Nikolic, Schneider, Hinzmann, Siegwart, ICRA 2016; `pirvs calib` finds it.
#pragma once

#include <Eigen/LU>

#include "bsp/api/imu.h"

namespace pirvs {

struct ImuIntrinsics {
  Mat3 gyro = Mat3::Identity();
  Mat3 accel = Mat3::Identity();
  Vec3 b_g = Vec3::Zero();
  Vec3 b_a = Vec3::Zero();

  bool given() const {
    return gyro != Mat3::Identity() || accel != Mat3::Identity() || b_g != Vec3::Zero() ||
           b_a != Vec3::Zero();
  }
};

class ImuCorrection {
 public:
  void configure(const ImuIntrinsics& intrinsics) {
    given_ = intrinsics.given();
    b_g_ = intrinsics.b_g;
    b_a_ = intrinsics.b_a;
    gyro_inverse_ = intrinsics.gyro.inverse();
    accel_inverse_ = intrinsics.accel.inverse();
  }
  void apply(ImuSample& sample) const {
    if (!given_) return;
    const Vec3 w = sample.w_B - b_g_, f = sample.f_B - b_a_;
    sample.w_B = gyro_inverse_ * w;
    sample.f_B = accel_inverse_ * f;
  }

 private:
  bool given_ = false;
  Mat3 gyro_inverse_ = Mat3::Identity(), accel_inverse_ = Mat3::Identity();
  Vec3 b_g_ = Vec3::Zero(), b_a_ = Vec3::Zero();
};

}  // namespace pirvs
