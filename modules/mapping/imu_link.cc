#include "modules/mapping/imu_link.h"

#include <algorithm>

#include <Eigen/Cholesky>

#include "core/math/so3.h"
#include "modules/imu/gravity.h"

namespace pirvs {
namespace {

const Vec3 kGravity_W(0, 0, -kGravity_m_s2);

}  // namespace

ImuLink make_link(int from, int to, const Preintegration& motion, const ImuNoise& noise) {
  ImuLink link;
  link.from = from;
  link.to = to;
  link.motion = motion;
  Mat9 cov = motion.cov;
  // Discretization and unmodelled vibration: a floor far below what matters, so that it inverts.
  cov.diagonal().array() += 1e-12;
  link.information = cov.llt().solve(Mat9::Identity());
  const double dt = std::max(motion.dt_s, 1e-3);
  link.walk_g = 1.0 / (noise.gyro_walk * noise.gyro_walk * dt);
  link.walk_a = 1.0 / (noise.accel_walk * noise.accel_walk * dt);
  return link;
}

Vec15 link_residual(const ImuLink& link, const BodyState& a, const BodyState& b) {
  const double dt = link.motion.dt_s;
  const Preintegration::Motion m = link.motion.at(a.b_g, a.b_a);
  const Mat3 R_aW = a.T_WB.R.transpose();
  Vec15 r;
  r.segment<3>(0) = so3_log(m.dR.transpose() * R_aW * b.T_WB.R);
  r.segment<3>(3) = R_aW * (b.v_WB - a.v_WB - kGravity_W * dt) - m.dv;
  r.segment<3>(6) = R_aW * (b.T_WB.p - a.T_WB.p - a.v_WB * dt - 0.5 * dt * dt * kGravity_W) - m.dp;
  r.segment<3>(9) = b.b_g - a.b_g;
  r.segment<3>(12) = b.b_a - a.b_a;
  return r;
}

void link_jacobians(const ImuLink& link, const BodyState& a, const BodyState& b, Mat15& J_a,
                    Mat15& J_b) {
  const Preintegration& motion = link.motion;
  const double dt = motion.dt_s;
  const Mat3 I = Mat3::Identity();
  const Mat3 R_aW = a.T_WB.R.transpose();
  const Vec3 bias_turn = motion.dR_dbg * (a.b_g - motion.b_g);
  const Mat3 dR = motion.dR * so3_exp(bias_turn);
  const Mat3 error = dR.transpose() * R_aW * b.T_WB.R;
  const Mat3 Jr_inverse = right_jacobian_inverse(so3_log(error));
  J_a.setZero();
  J_b.setZero();
  J_a.block<3, 3>(0, 0) = -Jr_inverse * b.T_WB.R.transpose() * a.T_WB.R;
  J_a.block<3, 3>(0, 9) =
      -Jr_inverse * error.transpose() * right_jacobian(bias_turn) * motion.dR_dbg;
  J_b.block<3, 3>(0, 0) = Jr_inverse;

  J_a.block<3, 3>(3, 0) = skew(R_aW * (b.v_WB - a.v_WB - kGravity_W * dt));
  J_a.block<3, 3>(3, 6) = -R_aW;
  J_a.block<3, 3>(3, 9) = -motion.dv_dbg;
  J_a.block<3, 3>(3, 12) = -motion.dv_dba;
  J_b.block<3, 3>(3, 6) = R_aW;

  J_a.block<3, 3>(6, 0) =
      skew(R_aW * (b.T_WB.p - a.T_WB.p - a.v_WB * dt - 0.5 * dt * dt * kGravity_W));
  J_a.block<3, 3>(6, 3) = -R_aW;
  J_a.block<3, 3>(6, 6) = -R_aW * dt;
  J_a.block<3, 3>(6, 9) = -motion.dp_dbg;
  J_a.block<3, 3>(6, 12) = -motion.dp_dba;
  J_b.block<3, 3>(6, 3) = R_aW;

  J_a.block<3, 3>(9, 9) = -I;
  J_a.block<3, 3>(12, 12) = -I;
  J_b.block<3, 3>(9, 9) = I;
  J_b.block<3, 3>(12, 12) = I;
}

Vec15 weigh(const ImuLink& link, const Vec15& x) {
  Vec15 out;
  out.head<9>() = link.information * x.head<9>();
  out.segment<3>(9) = link.walk_g * x.segment<3>(9);
  out.segment<3>(12) = link.walk_a * x.segment<3>(12);
  return out;
}

Mat15 weigh(const ImuLink& link, const Mat15& X) {
  Mat15 out;
  out.topRows<9>() = link.information * X.topRows<9>();
  out.middleRows<3>(9) = link.walk_g * X.middleRows<3>(9);
  out.middleRows<3>(12) = link.walk_a * X.middleRows<3>(12);
  return out;
}

}  // namespace pirvs
