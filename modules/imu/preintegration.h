// Sums IMU samples between two keyframes into one relative motion, once, for any later bias.
// In      consecutive samples (w_B rad/s, f_B m/s^2) and the biases they are linearized at.
// Out     dR = R_B0B1, dv_B0, dp_B0 (gravity left out), first-order bias Jacobians, covariance.
// Frames  B0, B1: body at the first, last sample. Error order of the covariance: theta (in B1), v,
//         p.
// Errors  none; dt_s <= 0 is a bug (the sensor door orders samples).
// Cost    ~0.35 us a sample, x86-64; no memory beyond the object.
// Source  Forster, Carlone, Dellaert, Scaramuzza, T-RO 2017, eqs. 26, 33-45, 59-63, midpoint
//         samples; the relative IMU constraint that the PIRVS paper names as future work (section
//         V.B).
#pragma once

#include "core/math/types.h"
#include "modules/imu/imu_noise.h"

namespace pirvs {

class Preintegration {
 public:
  void reset(const Vec3& b_g, const Vec3& b_a);
  // Adds the interval between two samples: rates and forces are taken at its middle.
  void add(const Vec3& w0_B, const Vec3& f0_B, const Vec3& w1_B, const Vec3& f1_B, double dt_s,
           const ImuNoise& noise);

  // The motion as it would have been integrated at other biases (first order).
  struct Motion {
    Mat3 dR;
    Vec3 dv, dp;
  };
  Motion at(const Vec3& b_g, const Vec3& b_a) const;

  double dt_s = 0.0;
  Mat3 dR = Mat3::Identity();
  Vec3 dv = Vec3::Zero(), dp = Vec3::Zero();
  Mat3 dR_dbg = Mat3::Zero();  // rotation vector in B1 per gyro bias
  Mat3 dv_dbg = Mat3::Zero(), dv_dba = Mat3::Zero();
  Mat3 dp_dbg = Mat3::Zero(), dp_dba = Mat3::Zero();
  Mat9 cov = Mat9::Zero();  // theta, v, p
  Vec3 b_g = Vec3::Zero(), b_a = Vec3::Zero();
};

}  // namespace pirvs
