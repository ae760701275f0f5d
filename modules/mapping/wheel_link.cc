#include "modules/mapping/wheel_link.h"

#include <Eigen/LU>

#include "core/math/so3.h"
#include "core/math/square.h"

namespace pirvs {
namespace {

constexpr double kFloor_m = 0.002;  // vibration and tyres, however short the way

}  // namespace

WheelLink make_link(int from, int to, const WheelPath& path) {
  const Mat3 cov = path.covariance() + square(kFloor_m) * Mat3::Identity();
  return {from, to, path, cov.inverse()};
}

// R_a' (p_b + R_b l - p_a) - l - way, l = p_BV.
Vec3 link_residual(const WheelLink& link, const BodyState& a, const BodyState& b) {
  const Vec3& l = link.path.p_BV;
  const Vec3 way = link.path.way_B0 + link.path.dway_dbg * (a.b_g - link.path.b_g);
  return a.T_WB.R.transpose() * (b.T_WB * l - a.T_WB.p) - l - way;
}

void link_jacobians(const WheelLink& link, const BodyState& a, const BodyState& b, Vec3x15& J_a,
                    Vec3x15& J_b) {
  const Vec3& l = link.path.p_BV;
  const Mat3 R_aW = a.T_WB.R.transpose();
  J_a.setZero();
  J_b.setZero();
  J_a.block<3, 3>(0, 0) = skew(R_aW * (b.T_WB * l - a.T_WB.p));
  J_a.block<3, 3>(0, 3) = -R_aW;
  J_a.block<3, 3>(0, 9) = -link.path.dway_dbg;
  J_b.block<3, 3>(0, 0) = -R_aW * b.T_WB.R * skew(l);
  J_b.block<3, 3>(0, 3) = R_aW;
}

}  // namespace pirvs
