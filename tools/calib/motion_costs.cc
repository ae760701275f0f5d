#include "tools/calib/motion_costs.h"

#include "core/math/so3.h"
#include "modules/imu/gravity.h"
#include "tools/calib/solver.h"

namespace pirvs::tools {
namespace {

template <int kRows, int kColumns>
using Block = Eigen::Map<Eigen::Matrix<double, kRows, kColumns, Eigen::RowMajor>>;

Vec3 vec3(const double* x) { return Eigen::Map<const Vec3>(x); }

Vec3 sum_of(const double* const* p, const double* weights) {
  Vec3 out = Vec3::Zero();
  for (int k = 0; k < kSplineOrder; ++k) out += weights[k] * vec3(p[k]);
  return out;
}

}  // namespace

Mat3 lower_triangular(const double* m) {
  Mat3 out;
  out << m[0], 0, 0, m[1], m[2], 0, m[3], m[4], m[5];
  return out;
}

bool ImuCost::Evaluate(double const* const* x, double* residuals, double** jacobians) const {
  constexpr int kQ = 0, kP = 6, kGravity = 12, kGyro = 13, kAccel = 14, kBias = 15;
  const RotationState state = rotation_at(x + kQ, reading_.basis, true);
  const Vec3 a_T = sum_of(x + kP, reading_.basis.b[2]);
  const Mat3 gyro = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(x[kGyro]);
  const Mat3 accel = lower_triangular(x[kAccel]);
  const Vec3 f_B = state.R_TB.transpose() * (a_T - kGravity_m_s2 * vec3(x[kGravity]));
  const double after = reading_.bias_share, before = 1 - after;
  const Vec3 b_g = before * vec3(x[kBias]) + after * vec3(x[kBias + 1]);
  const Vec3 b_a = before * vec3(x[kBias + 2]) + after * vec3(x[kBias + 3]);
  const double wg = 1 / reading_.gyro_sigma, wa = 1 / reading_.accel_sigma;
  Eigen::Map<Vec3>(residuals).noalias() = wg * (gyro * state.w_B + b_g - reading_.w_B);
  Eigen::Map<Vec3>(residuals + 3).noalias() = wa * (accel * f_B + b_a - reading_.f_B);
  if (jacobians == nullptr) return true;
  const Mat3 by_theta = wa * accel * skew(f_B);
  const Mat3 by_a = wa * accel * state.R_TB.transpose();
  for (int k = 0; k < kSplineOrder; ++k) {
    if (jacobians[kQ + k] != nullptr) {
      Block<6, 4> J(jacobians[kQ + k]);
      J.topLeftCorner<3, 3>() = wg * gyro * state.dw[k];
      J.bottomLeftCorner<3, 3>() = by_theta * state.dR[k];
      J.col(3).setZero();
    }
    if (jacobians[kP + k] != nullptr) {
      Block<6, 3> J(jacobians[kP + k]);
      J.topRows<3>().setZero();
      J.bottomRows<3>() = reading_.basis.b[2][k] * by_a;
    }
  }
  if (jacobians[kGravity] != nullptr) {
    Block<6, 3> J(jacobians[kGravity]);
    J.topRows<3>().setZero();
    J.bottomRows<3>() = -kGravity_m_s2 * by_a;
  }
  if (jacobians[kGyro] != nullptr) {
    Block<6, 9> J(jacobians[kGyro]);
    J.setZero();
    for (int i = 0; i < 3; ++i) J.block<1, 3>(i, 3 * i) = wg * state.w_B.transpose();
  }
  if (jacobians[kAccel] != nullptr) {
    Block<6, 6> J(jacobians[kAccel]);
    J.setZero();
    J(3, 0) = wa * f_B.x();
    J.block<1, 2>(4, 1) = wa * f_B.head<2>().transpose();
    J.block<1, 3>(5, 3) = wa * f_B.transpose();
  }
  for (int k = 0; k < 4; ++k) {
    if (jacobians[kBias + k] == nullptr) continue;
    Block<6, 3> J(jacobians[kBias + k]);
    J.setZero();
    const double share = k % 2 == 0 ? before : after;
    J.middleRows<3>(k < 2 ? 0 : 3) = (k < 2 ? wg : wa) * share * Mat3::Identity();
  }
  return true;
}

bool FrameCost::Evaluate(double const* const* x, double* residuals, double** jacobians) const {
  constexpr int kQ = 0, kP = 6, kR = 12, kT = 13, kTime = 14, kLens = 15;
  using Part = Eigen::Matrix<double, kFrameSize, 3>;
  const double t_s = t_camera_s_ + x[kTime][0] + x[kTime][1] * since_middle_s_;
  const SplineBasis basis = spline_basis((t_s - t0_s_) / dt_s_, dt_s_);
  const RotationState state = rotation_at(x + kQ, basis, jacobians != nullptr);
  const Mat3 R_BT = state.R_TB.transpose(), R_CB = matrix_of(x[kR]).transpose();
  const Vec3 p_BT = -(R_BT * sum_of(x + kP, basis.b[0]));
  const Mat3 R_CT = R_CB * R_BT;
  const Vec3 p_CT = R_CB * (p_BT - vec3(x[kT]));
  const Vec3 theta = so3_log(factor_.T_CT.R.transpose() * R_CT);
  Eigen::Matrix<double, kFrameSize, 1> e;
  e << theta, p_CT - factor_.T_CT.p, Eigen::Map<const LensVector>(x[kLens]) - factor_.lens;
  Eigen::Map<Eigen::Matrix<double, kFrameSize, 1>>(residuals).noalias() = factor_.A * e + factor_.c;
  if (jacobians == nullptr) return true;
  const Part A_R = factor_.A.leftCols<3>() * right_jacobian_inverse(theta);
  const Part A_p = factor_.A.middleCols<3>(3);
  const Part by_theta = -A_R * state.R_TB + A_p * R_CB * skew(p_BT);
  const Part by_p = -A_p * R_CT;
  for (int k = 0; k < kSplineOrder; ++k) {
    if (jacobians[kQ + k] != nullptr) {
      Block<kFrameSize, 4> J(jacobians[kQ + k]);
      J.leftCols<3>() = by_theta * state.dR[k];
      J.col(3).setZero();
    }
    if (jacobians[kP + k] != nullptr) {
      Block<kFrameSize, 3> J(jacobians[kP + k]);
      J = basis.b[0][k] * by_p;
    }
  }
  if (jacobians[kR] != nullptr) {
    Block<kFrameSize, 4> J(jacobians[kR]);
    J.leftCols<3>() = -A_R * R_CT.transpose() + A_p * skew(p_CT);
    J.col(3).setZero();
  }
  if (jacobians[kT] != nullptr) {
    Block<kFrameSize, 3> J(jacobians[kT]);
    J = -A_p * R_CB;
  }
  if (jacobians[kTime] != nullptr) {
    Block<kFrameSize, 2> J(jacobians[kTime]);
    J.col(0) = by_theta * state.w_B + by_p * sum_of(x + kP, basis.b[1]);
    J.col(1) = since_middle_s_ * J.col(0);
  }
  if (jacobians[kLens] != nullptr) {
    Block<kFrameSize, kLensSize> J(jacobians[kLens]);
    J = factor_.A.rightCols<kLensSize>();
  }
  return true;
}

bool WalkCost::Evaluate(double const* const* x, double* residuals, double** jacobians) const {
  Eigen::Map<Vec3>(residuals).noalias() = (vec3(x[1]) - vec3(x[0])) / sigma_;
  if (jacobians == nullptr) return true;
  for (int k = 0; k < 2; ++k) {
    if (jacobians[k] == nullptr) continue;
    Block<3, 3> J(jacobians[k]);
    J = (k == 0 ? -1 : 1) / sigma_ * Mat3::Identity();
  }
  return true;
}

}  // namespace pirvs::tools
