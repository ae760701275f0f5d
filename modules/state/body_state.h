// The state of the body at one instant, and its error: the 15 numbers that filter, preintegration
// and adjustment share.
// Frames  W: world, z up. B: IMU. The error of the attitude stands on the right, in B; those of
//         position and velocity in W.
// Units   rad, m, m/s; biases rad/s and m/s^2.
// Errors  none.
// Source  docs/conventions.md, "State and its error".
#pragma once

#include "core/base/time.h"
#include "core/math/se3.h"

namespace pirvs {

struct BodyState {
  TimeNs t = 0;
  SE3 T_WB;
  Vec3 v_WB = Vec3::Zero();
  Vec3 b_g = Vec3::Zero(), b_a = Vec3::Zero();
};

// Where each part of the error begins, in every 15-vector and 15 x 15 matrix.
enum : int { kTheta = 0, kPos = 3, kVel = 6, kBg = 9, kBa = 12 };

// x [+] delta: R Exp(d_theta), the rest added; and its inverse, a [-] b.
BodyState boxplus(const BodyState& state, const Vec15& delta);
Vec15 boxminus(const BodyState& a, const BodyState& b);

inline BodyState at_time(BodyState state, TimeNs t) {
  state.t = t;
  return state;
}

// A rigid motion T of W.
inline void move(const SE3& T, BodyState& state) {
  state.T_WB = T * state.T_WB;
  state.v_WB = T.R * state.v_WB;
}

// What T does to the error of a state: position and velocity are told in W, attitude in B.
inline Mat15 error_transform(const SE3& T) {
  Mat15 A = Mat15::Identity();
  A.block<3, 3>(3, 3) = A.block<3, 3>(6, 6) = T.R;
  return A;
}

}  // namespace pirvs
