#include "modules/imu/preintegration.h"

#include "core/base/assert.h"
#include "core/math/so3.h"

namespace pirvs {

void Preintegration::reset(const Vec3& bias_g, const Vec3& bias_a) {
  *this = Preintegration{};
  b_g = bias_g;
  b_a = bias_a;
}

void Preintegration::add(const Vec3& w0_B, const Vec3& f0_B, const Vec3& w1_B, const Vec3& f1_B,
                         double dt, const ImuNoise& noise) {
  PIRVS_ASSERT(dt > 0.0);
  const Vec3 theta = (0.5 * (w0_B + w1_B) - b_g) * dt;
  const Mat3 step_R = so3_exp(theta);
  const Mat3 step_Jr = right_jacobian(theta);
  // Each force is turned by the attitude at its own end of the interval (trapezoid in B0).
  const Mat3 R1 = dR * step_R;
  const Vec3 a0 = f0_B - b_a, a1 = f1_B - b_a;
  const Vec3 a_B0 = 0.5 * (dR * a0 + R1 * a1);

  const Mat3 dR1_dbg = step_R.transpose() * dR_dbg - step_Jr * dt;
  const Mat3 da_dtheta0 = -0.5 * (dR * skew(a0) + R1 * skew(a1) * step_R.transpose());
  const Mat3 da_dbg = -0.5 * (dR * skew(a0) * dR_dbg + R1 * skew(a1) * dR1_dbg);
  const Mat3 da_dba = -0.5 * (dR + R1);

  // Error transition F (theta, v, p); noise enters through the mean rate and the mean force.
  Mat9 F = Mat9::Identity();
  F.block<3, 3>(0, 0) = step_R.transpose();
  F.block<3, 3>(3, 0) = da_dtheta0 * dt;
  F.block<3, 3>(6, 0) = 0.5 * da_dtheta0 * dt * dt;
  F.block<3, 3>(6, 3) = Mat3::Identity() * dt;
  const Mat9 FP = F * cov;
  cov.noalias() = FP * F.transpose();
  const double q_g = noise.gyro_noise * noise.gyro_noise * dt;
  const double q_a = noise.accel_noise * noise.accel_noise * dt;
  cov.block<3, 3>(0, 0).diagonal().array() += q_g;
  cov.block<3, 3>(3, 3).diagonal().array() += q_a;
  cov.block<3, 3>(6, 6).diagonal().array() += 0.25 * q_a * dt * dt;
  cov.block<3, 3>(3, 6).diagonal().array() += 0.5 * q_a * dt;
  cov.block<3, 3>(6, 3).diagonal().array() += 0.5 * q_a * dt;

  dp_dbg += dv_dbg * dt + 0.5 * da_dbg * dt * dt;
  dp_dba += dv_dba * dt + 0.5 * da_dba * dt * dt;
  dv_dbg += da_dbg * dt;
  dv_dba += da_dba * dt;
  dR_dbg = dR1_dbg;

  dp += dv * dt + 0.5 * a_B0 * dt * dt;
  dv += a_B0 * dt;
  dR = orthonormalized(R1);
  dt_s += dt;
}

Preintegration::Motion Preintegration::at(const Vec3& bias_g, const Vec3& bias_a) const {
  const Vec3 d_g = bias_g - b_g, d_a = bias_a - b_a;
  return {dR * so3_exp(dR_dbg * d_g), dv + dv_dbg * d_g + dv_dba * d_a,
          dp + dp_dbg * d_g + dp_dba * d_a};
}

}  // namespace pirvs
