#include "modules/imu/propagation.h"

#include "core/math/so3.h"
#include "core/math/square.h"
#include "modules/imu/gravity.h"

namespace pirvs {

void propagate(const ImuSample& a, const ImuSample& b, const ImuNoise& noise, BodyState& state,
               Mat15& cov, Mat15* transition) {
  const double dt = to_seconds(b.t - a.t);
  const Mat3 R0 = state.T_WB.R;
  const Vec3 theta = (0.5 * (a.w_B + b.w_B) - state.b_g) * dt;
  const Mat3 step_R = so3_exp(theta);
  const Mat3 R1 = R0 * step_R;
  const Vec3 a0 = a.f_B - state.b_a, a1 = b.f_B - state.b_a;
  const Vec3 a_W = 0.5 * (R0 * a0 + R1 * a1) - Vec3(0, 0, kGravity_m_s2);  // eq. 3

  Mat15 F = Mat15::Identity();
  const Mat3 da_dtheta = -0.5 * (R0 * skew(a0) + R1 * skew(a1) * step_R.transpose());
  const Mat3 da_dbg = 0.5 * R1 * skew(a1) * right_jacobian(theta) * dt;
  const Mat3 da_dba = -0.5 * (R0 + R1);
  F.block<3, 3>(kTheta, kTheta) = step_R.transpose();
  F.block<3, 3>(kTheta, kBg) = -right_jacobian(theta) * dt;
  F.block<3, 3>(kPos, kTheta) = 0.5 * da_dtheta * dt * dt;
  F.block<3, 3>(kPos, kVel) = Mat3::Identity() * dt;
  F.block<3, 3>(kPos, kBg) = 0.5 * da_dbg * dt * dt;
  F.block<3, 3>(kPos, kBa) = 0.5 * da_dba * dt * dt;
  F.block<3, 3>(kVel, kTheta) = da_dtheta * dt;
  F.block<3, 3>(kVel, kBg) = da_dbg * dt;
  F.block<3, 3>(kVel, kBa) = da_dba * dt;
  if (transition != nullptr) *transition = F;
  const Mat15 FP = F * cov;
  cov.noalias() = FP * F.transpose();
  const ImuNoise white = bridged(noise, static_cast<double>(b.gap_s));
  cov.diagonal().segment<3>(kTheta).array() += square(white.gyro_noise) * dt;
  cov.diagonal().segment<3>(kVel).array() += square(white.accel_noise) * dt;
  cov.diagonal().segment<3>(kPos).array() += 0.25 * square(white.accel_noise * dt) * dt;
  cov.diagonal().segment<3>(kBg).array() += square(noise.gyro_walk) * dt;
  cov.diagonal().segment<3>(kBa).array() += square(noise.accel_walk) * dt;
  cov = (0.5 * (cov + cov.transpose())).eval();

  state.T_WB.p += state.v_WB * dt + 0.5 * a_W * dt * dt;  // eq. 5
  state.v_WB += a_W * dt;                                 // eq. 4
  state.T_WB.R = orthonormalized(R1);                     // eqs. 1, 2
  state.t = b.t;
}

}  // namespace pirvs
