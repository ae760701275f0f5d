#include "modules/state/body_state.h"

#include "core/math/so3.h"

namespace pirvs {

BodyState boxplus(const BodyState& state, const Vec15& delta) {
  BodyState out = state;
  out.T_WB.R = orthonormalized(state.T_WB.R * so3_exp(delta.segment<3>(kTheta)));
  out.T_WB.p += delta.segment<3>(kPos);
  out.v_WB += delta.segment<3>(kVel);
  out.b_g += delta.segment<3>(kBg);
  out.b_a += delta.segment<3>(kBa);
  return out;
}

Vec15 boxminus(const BodyState& a, const BodyState& b) {
  Vec15 delta;
  delta.segment<3>(kTheta) = so3_log(b.T_WB.R.transpose() * a.T_WB.R);
  delta.segment<3>(kPos) = a.T_WB.p - b.T_WB.p;
  delta.segment<3>(kVel) = a.v_WB - b.v_WB;
  delta.segment<3>(kBg) = a.b_g - b.b_g;
  delta.segment<3>(kBa) = a.b_a - b.b_a;
  return delta;
}

}  // namespace pirvs
