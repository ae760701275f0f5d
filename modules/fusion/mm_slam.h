// Measurement model: SLAM's pose and velocity, which stand in its own world W, as the fused state
// sees them through the anchor.
// In      state, anchored; SLAM's pose.
// Out     residual (9: theta in B, p and v in W), H (9 x 13), R (9 x 9).
//             R_WB = R_EW' R_EB      p_WB = R_EW' (p_EB - p_EW)      v_WB = R_EW' v_EB
// Frames  E, W, B; error order of fusion_state.h.
// Errors  none.
// Cost    ~0.3 us.
// Source  PIRVS paper, eq. 8; its R_GS^B is our R_EW', here estimated and with a place.
#pragma once

#include "core/math/so3.h"
#include "modules/fusion/fusion_state.h"

namespace pirvs {

inline FusionLinear<9> linearize_slam(const FusionState& state, const SlamMeasurement& slam) {
  const Mat3 R_WE = state.T_EW.R.transpose();
  const Vec3 arm_E = state.T_EB.p - state.T_EW.p;
  FusionLinear<9> out;
  out.r << so3_log(state.T_EB.R.transpose() * state.T_EW.R * slam.T_WB.R),
      slam.T_WB.p - R_WE * arm_E, slam.v_WB - R_WE * state.v_EB;
  out.H.setZero();
  out.H.block<3, 3>(0, kFuseTheta).setIdentity();
  out.H.block<3, 1>(0, kFuseYaw) = -state.T_EB.R.row(2).transpose();
  out.H.block<3, 3>(3, kFusePos) = R_WE;
  out.H.block<3, 3>(3, kFuseAnchor) = -R_WE;
  out.H.block<3, 1>(3, kFuseYaw) = R_WE * Vec3(arm_E.y(), -arm_E.x(), 0);
  out.H.block<3, 3>(6, kFuseVel) = R_WE;
  out.H.block<3, 1>(6, kFuseYaw) = R_WE * Vec3(state.v_EB.y(), -state.v_EB.x(), 0);
  Vec9 sigma;
  sigma << Vec3::Constant(slam.sigma_rad), Vec3::Constant(slam.sigma_m),
      Vec3::Constant(slam.sigma_m_s);
  out.R = sigma.cwiseAbs2().asDiagonal();
  return out;
}

}  // namespace pirvs
