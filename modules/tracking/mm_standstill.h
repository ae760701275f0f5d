// Measurement models of a device at rest: 0 = v_WB + n, w_mean_B = b_g + n and
// f_mean_B = R_WB' (0, 0, g) + b_a + n.
// In      state, the IMU's means while at rest, sigma of n (m/s, rad/s, m/s^2).
// Out     residual r (3), H = d h / d x (3 x 15), sigma: n ~ N(0, sigma^2 I).
// Frames  W, B; error order theta (in B), p, v (in W), b_g, b_a.
// Errors  none. Cost: negligible.
// Source  zero-velocity and zero-rate updates; own.
#pragma once

#include "core/math/so3.h"
#include "modules/imu/gravity.h"
#include "modules/map/map.h"

namespace pirvs {

template <int N>
struct Linear {
  Eigen::Matrix<double, N, 1> r;
  Eigen::Matrix<double, N, 15> H;
  double sigma;
};

inline Linear<3> linearize_zero_velocity(const BodyState& state, double sigma_m_s) {
  Linear<3> out{-state.v_WB, Eigen::Matrix<double, 3, 15>::Zero(), sigma_m_s};
  out.H.block<3, 3>(0, 6).setIdentity();
  return out;
}

inline Linear<3> linearize_zero_rate(const BodyState& state, const Vec3& w_mean_B,
                                     double sigma_rad_s) {
  Linear<3> out{w_mean_B - state.b_g, Eigen::Matrix<double, 3, 15>::Zero(), sigma_rad_s};
  out.H.block<3, 3>(0, 9).setIdentity();
  return out;
}

inline Linear<3> linearize_gravity(const BodyState& state, const Vec3& f_mean_B,
                                   double sigma_m_s2) {
  const Vec3 up_B = state.T_WB.R.transpose() * Vec3(0, 0, kGravity_m_s2);
  Linear<3> out{f_mean_B - up_B - state.b_a, Eigen::Matrix<double, 3, 15>::Zero(), sigma_m_s2};
  out.H.block<3, 3>(0, 0) = skew(up_B);
  out.H.block<3, 3>(0, 12).setIdentity();
  return out;
}

}  // namespace pirvs
