// Measurement models of a device at rest: 0 = v_WB + n and w_mean_B = b_g + n.
// In      state, the gyro's mean while at rest, sigma of n (m/s, rad/s).
// Out     residual r (3), H = d h / d x (3 x 15), sigma: n ~ N(0, sigma^2 I).
// Frames  W, B; error order theta (in B), p, v (in W), b_g, b_a.
// Errors  none. Cost: negligible.
// Source  zero-velocity and zero-rate updates; own.
#pragma once

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

}  // namespace pirvs
