// The relative IMU constraint between two keyframes: residual, Jacobians, information.
// In      the preintegrated motion and both states. Out: r (15): theta, v, p, b_g, b_a; J to the 15
//         errors of each state; cost r' Omega r.
// Frames  residuals in the first body frame (theta in the second).
// Errors  none. Cost: ~1.5 us, x86-64.
// Source  Forster, Carlone, Dellaert, Scaramuzza, T-RO 2017, eqs. 45, 48 and appendix C.
#pragma once

#include "modules/map/map.h"

namespace pirvs {

struct ImuLink {
  int from = -1, to = -1;  // frames of the bundle
  Preintegration motion;
  Mat9 information;               // of theta, v, p
  double walk_g = 0, walk_a = 0;  // 1 / variance of the bias steps
};

ImuLink make_link(int from, int to, const Preintegration& motion, const ImuNoise& noise);
Vec15 link_residual(const ImuLink& link, const BodyState& a, const BodyState& b);
void link_jacobians(const ImuLink& link, const BodyState& a, const BodyState& b, Mat15& J_a,
                    Mat15& J_b);
// Omega x: the information of all 15, block diagonal.
Vec15 weigh(const ImuLink& link, const Vec15& x);
Mat15 weigh(const ImuLink& link, const Mat15& X);

}  // namespace pirvs
