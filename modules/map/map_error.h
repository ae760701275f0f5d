// How far the map itself, near one place, may be from where it should be: the error that matching
// against it cannot see, told as one rigid motion of all that is near.
// In      covariance of (theta, p): a small turn of W about `at`, and a shift of W.
// Out     the same about another place; what it does to a state.
// Frames  theta and p in W. State errors: theta (in B, right), p, v (in W), b_g, b_a.
// Units   rad, m.
// Errors  none. Cost: ~0.3 us each.
// Source  own; docs/adr/0007-error-of-the-map.md.
#pragma once

#include "core/math/so3.h"
#include "modules/imu/gravity.h"
#include "modules/map/map.h"

namespace pirvs {

using Mat15x6 = Eigen::Matrix<double, 15, 6>;

// How uncertain the map is about one of its places.
struct MapError {
  Mat6 cov = Mat6::Zero();
  Vec3 at = Vec3::Zero();
};

// d state error / d (theta, p): everything turns about `at`, then shifts. Biases stay.
inline Mat15x6 rigid_motion(const BodyState& state, const Vec3& at) {
  Mat15x6 G = Mat15x6::Zero();
  G.block<3, 3>(0, 0) = state.T_WB.R.transpose();
  G.block<3, 3>(3, 0) = -skew(state.T_WB.p - at);
  G.block<3, 3>(3, 3).setIdentity();
  G.block<3, 3>(6, 0) = -skew(state.v_WB);
  return G;
}

// The same where the IMU's samples stay what they are: what turns does not turn gravity, so the
// difference is taken for bias. At rest nothing else could tell tilt from bias.
inline Mat15x6 rigid_motion_under_gravity(const BodyState& state, const Vec3& at) {
  Mat15x6 G = rigid_motion(state, at);
  G.block<3, 3>(12, 0) = -state.T_WB.R.transpose() * skew(Vec3(0, 0, kGravity_m_s2));
  return G;
}

// The same motion told about `to` instead of `from`: a turn reaches farther the farther away.
inline Mat6 motion_about(const Vec3& to, const Vec3& from) {
  Mat6 A = Mat6::Identity();
  A.block<3, 3>(3, 0) = -skew(to - from);
  return A;
}

inline Mat6 error_about(const Vec3& to, const Vec3& from, const Mat6& cov) {
  const Mat6 A = motion_about(to, from);
  return A * cov * A.transpose();
}

// Of a map that a rigid motion T of W has moved: what was along its axes is along the turned ones.
inline Mat6 turned(const SE3& T, const Mat6& cov) {
  Mat6 A = Mat6::Zero();
  A.block<3, 3>(0, 0) = A.block<3, 3>(3, 3) = T.R;
  return A * cov * A.transpose();
}

// Of a pose with error (theta in B, p): the map's error about the place of that pose.
inline Mat6 error_of_pose(const Mat3& R_WB, const Mat6& cov) {
  Mat6 A = Mat6::Identity();
  A.block<3, 3>(0, 0) = R_WB;
  return A * cov * A.transpose();
}

// The four of (theta, p) that gravity does not tell.
inline Vec4 gauge_of(const Vec6& xi) { return xi.tail<4>(); }
inline Mat4 gauge_of(const Mat6& cov) { return cov.bottomRightCorner<4, 4>(); }

// The rigid motion of a correction about the place p_W: what it does to all that is near.
inline SE3 motion_of(const Vec6& xi, const Vec3& p_W) {
  SE3 T;
  T.R = so3_exp(xi.head<3>());
  T.p = p_W + xi.tail<3>() - T.R * p_W;
  return T;
}

}  // namespace pirvs
