// Measurement model: place and velocity of a GNSS antenna at the end of its lever arm.
// In      state; the antenna in B; place or velocity in E and its variances.
// Out     residual (3), H (3 x 13), R (3 x 3).
//             z_p = p_EB + R_EB p_BA      z_v = v_EB + R_EB (w_B x p_BA)
// Frames  E, B; error order of fusion_state.h. The noise of w_B is left out: 0.01 rad/s at 1 m.
// Errors  none.
// Cost    ~0.1 us.
// Source  PIRVS paper, eq. 9, with a lever arm.
#pragma once

#include "core/math/so3.h"
#include "modules/fusion/fusion_state.h"

namespace pirvs {

inline FusionLinear<3> linearize_gnss_position(const FusionState& state, const Vec3& p_BA,
                                               const Vec3& p_EA, const Vec3& variance) {
  FusionLinear<3> out;
  out.r = p_EA - state.T_EB * p_BA;
  out.H.setZero();
  out.H.block<3, 3>(0, kFuseTheta) = -state.T_EB.R * skew(p_BA);
  out.H.block<3, 3>(0, kFusePos).setIdentity();
  out.R = variance.asDiagonal();
  return out;
}

inline FusionLinear<3> linearize_gnss_velocity(const FusionState& state, const Vec3& p_BA,
                                               const Vec3& v_EA, const Vec3& variance) {
  const Vec3 swing_B = skew(state.w_B) * p_BA;
  FusionLinear<3> out;
  out.r = v_EA - (state.v_EB + state.T_EB.R * swing_B);
  out.H.setZero();
  out.H.block<3, 3>(0, kFuseTheta) = -state.T_EB.R * skew(swing_B);
  out.H.block<3, 3>(0, kFuseVel).setIdentity();
  out.R = variance.asDiagonal();
  return out;
}

}  // namespace pirvs
