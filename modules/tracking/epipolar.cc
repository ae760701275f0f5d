#include "modules/tracking/epipolar.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/math/so3.h"

namespace pirvs {
namespace {

constexpr int kBearingsMin = 12;

// Of a symmetric non-negative M, by inverse iteration.
Vec3 smallest_eigenvector(const Mat3& M) {
  const Mat3 inverse = (M + Mat3::Identity() * (1e-9 * M.trace() + 1e-15)).inverse();
  Vec3 v(0.6, 0.48, 0.64);
  for (int i = 0; i < 16; ++i) v = (inverse * v).normalized();
  return v;
}

}  // namespace

Mat32 tangent_of(const Vec3& g) {
  Mat32 basis;
  basis.col(0) = g.unitOrthogonal();
  basis.col(1) = g.normalized().cross(basis.col(0));
  return basis;
}

bool add_epipolar_planes(const BearingPairs& bearings, const Preintegration& motion,
                         double sigma_rad, Mat3& H, Vec3& g) {
  if (bearings.size() < kBearingsMin) return false;
  struct Plane {
    Vec3 n;
    Mat3 J;  // of n to the bias
  };
  FixedVector<Plane, BearingPairs::capacity()> planes;
  Mat3 M = Mat3::Zero();
  for (const BearingPair& pair : bearings) {
    Plane plane;
    plane.n = pair.a_B.cross(motion.dR * pair.b_B);
    plane.J = -skew(pair.a_B) * motion.dR * skew(pair.b_B) * motion.dR_dbg;
    M += plane.n * plane.n.transpose();
    (void)planes.push_back(plane);  // as many as bearings
  }
  const Vec3 t = smallest_eigenvector(M);
  const Mat32 T = tangent_of(t);
  Mat3 H_bb = Mat3::Zero();
  Mat32 H_bt = Mat32::Zero();
  Mat2 H_tt = Mat2::Identity() * 1e-9;
  Vec3 g_b = Vec3::Zero();
  Vec2 g_t = Vec2::Zero();
  for (const Plane& plane : planes) {
    const double r = t.dot(plane.n);
    const double weight = huber_weight(std::fabs(r) / sigma_rad);
    const Vec3 J_b = plane.J.transpose() * t;
    const Vec2 J_t = T.transpose() * plane.n;
    H_bb += weight * J_b * J_b.transpose();
    H_bt += weight * J_b * J_t.transpose();
    H_tt += weight * J_t * J_t.transpose();
    g_b += weight * r * J_b;
    g_t += weight * r * J_t;
  }
  const Mat2 H_tt_inverse = H_tt.inverse();
  H += H_bb - H_bt * H_tt_inverse * H_bt.transpose();
  g += g_b - H_bt * H_tt_inverse * g_t;
  return true;
}

}  // namespace pirvs
