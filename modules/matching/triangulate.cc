#include "modules/matching/triangulate.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace pirvs {
namespace {

// Least squares over the distances from all rays: sum (I - f f') (p - c) = 0.
bool intersect(const View* views, int count, Triangulated& out) {
  Mat3 A = Mat3::Zero();
  Vec3 b = Vec3::Zero(), first_f_W = Vec3::Zero();
  double cos_min = 1;
  for (int i = 0; i < count; ++i) {
    Vec3 f_C;
    if (!views[i].camera->unproject(views[i].uv, f_C)) return false;
    const Vec3 f_W = views[i].T_CW.R.transpose() * f_C;
    const Vec3 c_W = -(views[i].T_CW.R.transpose() * views[i].T_CW.p);
    const Mat3 M = Mat3::Identity() - f_W * f_W.transpose();
    A += M;
    b += M * c_W;
    if (i == 0) first_f_W = f_W;
    cos_min = std::min(cos_min, first_f_W.dot(f_W));
  }
  out.parallax_rad = std::sqrt(std::max(0.0, 2 * (1 - cos_min)));  // small angles
  if (out.parallax_rad < 1e-3) return false;
  out.p_W = A.inverse() * b;
  return out.p_W.allFinite();
}

}  // namespace

bool triangulate(const View* views, int count, double sigma_px, Triangulated& out) {
  if (count < 2 || !intersect(views, count, out)) return false;
  for (int iteration = 0; iteration < 5; ++iteration) {
    Mat3 H = Mat3::Zero();
    Vec3 g = Vec3::Zero();
    out.residual_px_max = 0;
    for (int i = 0; i < count; ++i) {
      Vec2 uv;
      Mat23 J_C;
      const Vec3 p_C = views[i].T_CW * out.p_W;
      if (p_C.squaredNorm() < 1e-4) return false;
      if (!views[i].camera->project(p_C, uv, J_C)) return false;
      const Vec2 r = views[i].uv - uv;
      const Mat23 J = J_C * views[i].T_CW.R;
      H += J.transpose() * J;
      g += J.transpose() * r;
      out.residual_px_max = std::max(out.residual_px_max, r.norm());
    }
    bool invertible = false;
    Mat3 H_inverse;
    H.computeInverseWithCheck(H_inverse, invertible, 1e-12);
    if (!invertible) return false;
    out.cov = sigma_px * sigma_px * H_inverse;
    const Vec3 step = H_inverse * g;
    out.p_W += step;
    if (step.norm() < 1e-4 * (1 + out.p_W.norm())) return out.p_W.allFinite();
  }
  return false;
}

}  // namespace pirvs
