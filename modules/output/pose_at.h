// The pose at a time between two of the feed: of an edge on a pin, say.
// In      Two poses of one epoch, a before b; a.state.t <= t <= b.state.t.
// Out     Place and velocity on the line between both, attitude on the great circle. All else is
//         b's, whose covariance is the later and larger.
// Errors  none.
// Cost    ~0.3 us. At 200 Hz and 20 m/s^2 a line is off by 0.06 mm at most.
#pragma once

#include "core/math/so3.h"
#include "modules/output/pose.h"

namespace pirvs {

inline Pose pose_at(const Pose& a, const Pose& b, TimeNs t) {
  Pose out = b;
  out.state.t = t;
  const TimeNs whole = b.state.t - a.state.t;
  if (whole <= 0) return out;
  const double s = static_cast<double>(t - a.state.t) / static_cast<double>(whole);
  const SE3 &T0 = a.state.T_WB, &T1 = b.state.T_WB;
  out.state.T_WB.p = T0.p + s * (T1.p - T0.p);
  out.state.T_WB.R = T0.R * so3_exp(s * so3_log(T0.R.transpose() * T1.R));
  out.state.v_WB = a.state.v_WB + s * (b.state.v_WB - a.state.v_WB);
  return out;
}

}  // namespace pirvs
