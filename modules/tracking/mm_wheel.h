// Measurement models of wheels: the velocity of V's origin in the axes of V, which is forward
// alone, and the turn rate about z of V.
//   (u, 0, 0) = R_VB (R_WB' (v_WB + dt a_WB) + (w_B - b_g) x p_BV) + n,
//   w_z = z_V' R_VB (w_B - b_g) + n.
// In      state and IMU sample at its time; the speed, measured dt later, and how sure it is; T_BV.
// Out     residual r and H = d h / d x, each row divided by its sigma: n ~ N(0, I).
// Frames  W, B; V: wheel_calibration.h. Error order theta (in B), p, v (in W), b_g, b_a.
// Errors  none. Cost: negligible.
// Source  docs/conventions.md, "Wheels".
#pragma once

#include <algorithm>
#include <cmath>

#include "modules/imu/imu_sample.h"
#include "modules/tracking/mm_standstill.h"
#include "modules/wheels/wheel_odometry.h"

namespace pirvs {

// Errors that stay the same for correlated_s count once in that time, however many samples tell
// them.
inline double thinned(double sigma, double correlated_s, TimeNs dt_ns) {
  const double dt_s = std::max(to_seconds(dt_ns), 1e-3);
  return dt_ns > 0 && dt_s < correlated_s ? sigma * std::sqrt(correlated_s / dt_s) : sigma;
}

inline Linear<3> linearize_wheel_speed(const BodyState& state, const ImuSample& sample,
                                       const WheelVelocity& wheel, const SE3& T_BV,
                                       double correlated_s) {
  const Mat3 R_VB = T_BV.R.transpose(), R_BW = state.T_WB.R.transpose();
  const Vec3 a_W = state.T_WB.R * (sample.f_B - state.b_a) - Vec3(0, 0, kGravity_m_s2);
  const Vec3 v_B = R_BW * (state.v_WB + to_seconds(wheel.t - state.t) * a_W);
  const Vec3 sigma(wheel.sigma_m_s, wheel.side_sigma_m_s, wheel.side_sigma_m_s);
  Linear<3> out{
      Vec3(wheel.forward_m_s, 0, 0) - R_VB * (v_B + skew(sample.w_B - state.b_g) * T_BV.p),
      Eigen::Matrix<double, 3, 15>::Zero(), 1};
  out.H.block<3, 3>(0, 0) = R_VB * skew(v_B);
  out.H.block<3, 3>(0, 6) = R_VB * R_BW;
  out.H.block<3, 3>(0, 9) = R_VB * skew(T_BV.p);
  for (int i = 0; i < 3; ++i) {
    const double weight = 1 / thinned(sigma[i], correlated_s, wheel.dt_ns);
    out.r[i] *= weight;
    out.H.row(i) *= weight;
  }
  return out;
}

// How the speed's residual changes as the wheels are larger than they are taken for.
inline Vec3 per_wheel_scale(const WheelVelocity& wheel, double correlated_s) {
  return Vec3(-wheel.forward_m_s / thinned(wheel.sigma_m_s, correlated_s, wheel.dt_ns), 0, 0);
}

inline Linear<1> linearize_wheel_turn(const BodyState& state, const ImuSample& sample,
                                      const WheelVelocity& wheel, const SE3& T_BV,
                                      double correlated_s) {
  const double weight = 1 / thinned(wheel.turn_sigma_rad_s, correlated_s, wheel.dt_ns);
  const Vec3 z_B = T_BV.R.col(2);
  Linear<1> out{
      Eigen::Matrix<double, 1, 1>(weight * (wheel.turn_rad_s - z_B.dot(sample.w_B - state.b_g))),
      Eigen::Matrix<double, 1, 15>::Zero(), 1};
  out.H.block<1, 3>(0, 9) = -weight * z_B.transpose();
  return out;
}

}  // namespace pirvs
