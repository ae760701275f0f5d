#include "modules/link/vehicle_pose.h"

#include <cmath>

#include "core/math/so3.h"
#include "core/math/trig.h"

namespace pirvs {

Mat3 turned_over() { return Vec3(1, -1, -1).asDiagonal(); }

Mat3 mounting(const Vec3& roll_pitch_yaw_rad) {
  const Vec3& a = roll_pitch_yaw_rad;
  return so3_exp(Vec3(0, 0, a.z())) * so3_exp(Vec3(0, a.y(), 0)) * so3_exp(Vec3(a.x(), 0, 0));
}

VehiclePose vehicle_pose(const Pose& pose, const Mat3& R_VB) {
  const Mat3 R_LW = turned_over();
  const Mat3 R_DB = turned_over() * R_VB;
  const Mat3& R_WB = pose.state.T_WB.R;
  const Vec3 v_B = R_WB.transpose() * pose.state.v_WB;
  VehiclePose out;
  out.p_LD = R_LW * pose.state.T_WB.p;
  out.R_LD = R_LW * R_WB * R_DB.transpose();
  out.v_LD = R_LW * pose.state.v_WB;
  out.v_D = R_DB * v_B;
  out.w_D = R_DB * pose.w_B;
  // R_WB Exp(theta) = Exp(R_WB theta) R_WB: an error about B's axes is one about W's, turned.
  Eigen::Matrix<double, 6, 9> J = Eigen::Matrix<double, 6, 9>::Zero();
  J.block<3, 3>(0, kPos) = R_LW;
  J.block<3, 3>(3, kTheta) = R_LW * R_WB;
  out.cov_pose = J * pose.cov * J.transpose();
  // v_B = R_WB' v_WB moves by R_WB' dv + [v_B]x theta.
  Eigen::Matrix<double, 3, 9> H = Eigen::Matrix<double, 3, 9>::Zero();
  H.block<3, 3>(0, kTheta) = R_DB * skew(v_B);
  H.block<3, 3>(0, kVel) = R_DB * R_WB.transpose();
  out.cov_v_D = H * pose.cov * H.transpose();
  out.cov_v_LD = R_LW * pose.cov.block<3, 3>(kVel, kVel) * R_LW.transpose();
  return out;
}

Vec3 roll_pitch_yaw(const Mat3& R) {
  const double level = std::sqrt(R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0));
  return {arctan2(R(2, 1), R(2, 2)), arctan2(-R(2, 0), level), arctan2(R(1, 0), R(0, 0))};
}

}  // namespace pirvs
