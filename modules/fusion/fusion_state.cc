#include "modules/fusion/fusion_state.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

using Mat4 = Eigen::Matrix<double, 4, 4>;
// Matrices and vectors of any size up to the state's: with a type for each size this file took a
// minute to compile.
using Block =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kFusionErrors, kFusionErrors>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kFusionErrors, 1>;

Block carried(const Block& J, const Block& cov) { return J * cov * J.transpose(); }

Mat3 turn_about_z(double yaw) {
  double s, c;
  sincos(yaw, s, c);
  Mat3 R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R;
}

// The heading of a rotation that is one about the vertical but for a small tilt.
double yaw_of(const Mat3& R) { return arctan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)); }

void symmetrize(Mat13& cov) { cov = (0.5 * (cov + cov.transpose())).eval(); }

// Of theta, p, v of SLAM's pose from one frame to the next.
Mat9 noise_of(const SlamMeasurement& slam) {
  Vec9 sigma;
  sigma << Vec3::Constant(slam.sigma_rad), Vec3::Constant(slam.sigma_m),
      Vec3::Constant(slam.sigma_m_s);
  return sigma.cwiseAbs2().asDiagonal();
}

double update_rows(FusionState& state, const Rows& r, const Block& H, const Block& R, double gate) {
  const Block PH = state.cov * H.transpose();
  const Block S = H * PH + R;
  const Eigen::LLT<Block> factor(S);
  if (factor.info() != Eigen::Success) return HUGE_VAL;
  const Rows weighted = factor.solve(r);
  const double nis = r.dot(weighted);
  if (!(nis <= gate)) return nis;
  const Block K_transposed = factor.solve(PH.transpose());
  const Rows delta = K_transposed.transpose() * r;
  state = boxplus(state, delta);
  state.cov -= K_transposed.transpose() * PH.transpose();
  symmetrize(state.cov);
  return nis;
}

}  // namespace

FusionState boxplus(const FusionState& state, const Vec13& delta) {
  FusionState out = state;
  out.T_EB.R = state.T_EB.R * so3_exp(delta.segment<3>(kFuseTheta));
  out.T_EB.p += delta.segment<3>(kFusePos);
  out.v_EB += delta.segment<3>(kFuseVel);
  out.T_EW.p += delta.segment<3>(kFuseAnchor);
  out.T_EW.R = turn_about_z(delta[kFuseYaw] + yaw_of(state.T_EW.R));
  return out;
}

Vec13 boxminus(const FusionState& a, const FusionState& b) {
  Vec13 out;
  out << so3_log(b.T_EB.R.transpose() * a.T_EB.R), a.T_EB.p - b.T_EB.p, a.v_EB - b.v_EB,
      a.T_EW.p - b.T_EW.p, yaw_of(a.T_EW.R * b.T_EW.R.transpose());
  return out;
}

double turning_s(const FusionState& state, double dt_s) {
  const double age_s = to_seconds(state.t - state.w_t);
  return std::clamp(kRateHolds_s - age_s, 0.0, dt_s);
}

Mat13 transition(const FusionState& state, double dt_s) {
  Mat13 F = Mat13::Identity();
  F.block<3, 3>(kFuseTheta, kFuseTheta) = so3_exp(-turning_s(state, dt_s) * state.w_B);
  F.block<3, 3>(kFusePos, kFuseVel) = dt_s * Mat3::Identity();
  return F;
}

void propagate(FusionState& state, TimeNs t, double accel_noise, double turn_noise) {
  const double dt = to_seconds(t - state.t);
  if (!(dt > 0)) return;
  const Mat13 F = transition(state, dt);
  const Vec3 turn = turning_s(state, dt) * state.w_B;
  state.t = t;
  state.T_EB.p += dt * state.v_EB;
  state.T_EB.R = orthonormalized(state.T_EB.R * so3_exp(turn));
  state.cov = carried(F, state.cov);
  const double accel2 = accel_noise * accel_noise;
  for (int i = 0; i < 3; ++i) {
    state.cov(kFuseTheta + i, kFuseTheta + i) += turn_noise * turn_noise * dt;
    state.cov(kFusePos + i, kFusePos + i) += accel2 * dt * dt * dt / 3;
    state.cov(kFusePos + i, kFuseVel + i) += accel2 * dt * dt / 2;
    state.cov(kFuseVel + i, kFusePos + i) += accel2 * dt * dt / 2;
    state.cov(kFuseVel + i, kFuseVel + i) += accel2 * dt;
  }
  symmetrize(state.cov);
}

void let_drift(FusionState& state, double var_horizontal_m2, double var_vertical_m2,
               double var_yaw_rad2) {
  // p_EW moves by -dyaw z x (p_EB - p_EW) when W turns by dyaw about the body.
  const Vec3 arm = state.T_EB.p - state.T_EW.p;
  const Vec3 u(arm.y(), -arm.x(), 0);
  state.cov.block<3, 3>(kFuseAnchor, kFuseAnchor) += var_yaw_rad2 * u * u.transpose();
  state.cov.block<3, 1>(kFuseAnchor, kFuseYaw) += var_yaw_rad2 * u;
  state.cov.block<1, 3>(kFuseYaw, kFuseAnchor) += var_yaw_rad2 * u.transpose();
  state.cov(kFuseYaw, kFuseYaw) += var_yaw_rad2;
  state.cov(kFuseAnchor, kFuseAnchor) += var_horizontal_m2;
  state.cov(kFuseAnchor + 1, kFuseAnchor + 1) += var_horizontal_m2;
  state.cov(kFuseAnchor + 2, kFuseAnchor + 2) += var_vertical_m2;
}

template <int N>
double update(FusionState& state, const FusionLinear<N>& m, double gate) {
  return update_rows(state, m.r, m.H, m.R, gate);
}

template double update<2>(FusionState&, const FusionLinear<2>&, double);
template double update<3>(FusionState&, const FusionLinear<3>&, double);
template double update<9>(FusionState&, const FusionLinear<9>&, double);

void follow_jump(FusionState& state, const SlamMeasurement& slam) {
  state.T_EW.R = turn_about_z(yaw_of(state.T_EB.R * slam.T_WB.R.transpose()));
  state.T_EW.p = state.T_EB.p - state.T_EW.R * slam.T_WB.p;
}

void anchor_anew(FusionState& state, const SlamMeasurement& slam) {
  follow_jump(state, slam);
  const Vec3 arm = state.T_EB.p - state.T_EW.p;
  // Errors (theta, p, v) of the body and (theta, p, v) of SLAM's pose to all errors.
  Eigen::Matrix<double, kFusionErrors, 9> J = Eigen::Matrix<double, kFusionErrors, 9>::Zero();
  J.topLeftCorner<9, 9>().setIdentity();
  const Eigen::Matrix<double, 1, 3> yaw_theta = state.T_EB.R.row(2);
  const Vec3 u(arm.y(), -arm.x(), 0);  // -z x arm
  J.block<1, 3>(kFuseYaw, kFuseTheta) = yaw_theta;
  J.block<3, 3>(kFuseAnchor, kFusePos).setIdentity();
  J.block<3, 3>(kFuseAnchor, kFuseTheta) = u * yaw_theta;
  Eigen::Matrix<double, kFusionErrors, 9> J_slam = Eigen::Matrix<double, kFusionErrors, 9>::Zero();
  J_slam.block<1, 3>(kFuseYaw, 0) = -yaw_theta;
  J_slam.block<3, 3>(kFuseAnchor, 0) = -u * yaw_theta;
  J_slam.block<3, 3>(kFuseAnchor, 3) = -state.T_EW.R;
  const Mat9 cov = state.cov.topLeftCorner<9, 9>();
  state.cov = carried(J, cov) + carried(J_slam, noise_of(slam));
  symmetrize(state.cov);
  state.w_B = slam.w_B;
  state.w_t = state.t;
  state.has_anchor = true;
  state.epoch = slam.epoch;
}

void place_by_anchor(FusionState& state, const SE3& T_EW, const Mat4& cov,
                     const SlamMeasurement& slam) {
  state.T_EW = T_EW;
  state.T_EB = T_EW * slam.T_WB;
  state.v_EB = T_EW.R * slam.v_WB;
  state.w_B = slam.w_B;
  state.w_t = state.t;
  state.placed = state.anchored = state.has_anchor = true;
  state.epoch = slam.epoch;
  const Vec3 arm = state.T_EB.p - T_EW.p;
  Eigen::Matrix<double, kFusionErrors, 4> J = Eigen::Matrix<double, kFusionErrors, 4>::Zero();
  J.block<3, 1>(kFuseTheta, 3) = state.T_EB.R.row(2).transpose();
  J.block<3, 3>(kFusePos, 0).setIdentity();
  J.block<3, 1>(kFusePos, 3) = Vec3(-arm.y(), arm.x(), 0);
  J.block<3, 1>(kFuseVel, 3) = Vec3(-state.v_EB.y(), state.v_EB.x(), 0);
  J.block<4, 4>(kFuseAnchor, 0).setIdentity();
  state.cov = carried(J, cov);
  // Noise of one pose is the same in all directions: no rotation turns it.
  state.cov.topLeftCorner<9, 9>() += noise_of(slam);
  symmetrize(state.cov);
}

void forget_heading(FusionState& state, const Vec3& p_BA) {
  const Mat3 place_theta = -state.T_EB.R * skew(p_BA);
  Eigen::Matrix<double, 6, kFusionErrors> J = Eigen::Matrix<double, 6, kFusionErrors>::Zero();
  J.block<3, 3>(0, kFuseTheta) = place_theta;
  J.block<3, 3>(0, kFusePos).setIdentity();
  J.block<3, 3>(3, kFuseVel).setIdentity();
  const Mat6 cov = carried(J, state.cov);
  const Mat4 anchor_cov = state.cov.bottomRightCorner<4, 4>();
  state.T_EB.p = state.T_EB * p_BA;
  state.T_EB.R.setIdentity();
  state.w_B.setZero();
  state.anchored = false;
  state.cov.setZero();
  state.cov.block<6, 6>(kFusePos, kFusePos) = cov;
  state.cov.bottomRightCorner<4, 4>() = anchor_cov;
  symmetrize(state.cov);
}

double yaw_variance(const FusionState& state) {
  const Eigen::Matrix<double, 1, 3> up = state.T_EB.R.row(2);
  return (up * state.cov.topLeftCorner<3, 3>() * up.transpose())(0, 0);
}

}  // namespace pirvs
