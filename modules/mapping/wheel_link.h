// The way of the wheels between two keyframes as a constraint: residual, Jacobians, information.
// In      the path and both states. Out: r (3) in the axes of the first body; J to the 15 errors of
//         each state; cost r' Omega r.
// Frames  wheel_path.h. Error order theta (in B, right), p, v (in W), b_g, b_a.
// Errors  none. Cost: ~0.2 us, x86-64.
// Source  docs/conventions.md, "Wheels".
#pragma once

#include "modules/map/map.h"

namespace pirvs {

using Vec3x15 = Eigen::Matrix<double, 3, 15>;

struct WheelLink {
  int from = -1, to = -1;  // frames of the bundle
  WheelPath path;
  Mat3 information;
};

// path.holds()
WheelLink make_link(int from, int to, const WheelPath& path);
Vec3 link_residual(const WheelLink& link, const BodyState& a, const BodyState& b);
void link_jacobians(const WheelLink& link, const BodyState& a, const BodyState& b, Vec3x15& J_a,
                    Vec3x15& J_b);

}  // namespace pirvs
