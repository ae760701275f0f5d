// Measurement model: a map point seen by one camera, uv = project(T_CB T_BW p_W) + n.
// In      pose of the body, the correspondence, the camera. n ~ N(0, sigma_px^2 I) and, through the
//         projection, point_cov_scale times the point's own covariance.
// Out     residual uv - h (2), J = d h / d (theta, p) (2 x 6), covariance R of the residual (2 x
//         2).
// Frames  W, B, C; theta in B (right), p in W.
// Errors  false: behind the camera or outside its model; the outputs are then undefined.
// Cost    ~40 ns, x86-64.
// Source  PIRVS paper, eq. 6.
#pragma once

#include "core/camera/camera.h"
#include "core/math/so3.h"
#include "modules/map/map.h"

namespace pirvs {

enum class Gate : uint8_t { kAccepted, kBehindCamera, kChi2, kCount };
const char* name(Gate gate);

struct Correspondence {
  Vec3 p_W;
  Mat3 cov_W;  // of p_W, m^2
  Vec2 uv;
  double sigma_px;
  int camera;
  Gate gate;  // the filter's verdict
};

struct Reprojection {
  Vec2 r;
  Mat26 J;
  Mat2 R;
};

inline bool linearize_reprojection(const SE3& T_WB, const Correspondence& c, const Camera& camera,
                                   const SE3& T_CB, double point_cov_scale, Reprojection& out) {
  const Mat3 R_BW = T_WB.R.transpose();
  const Vec3 p_B = R_BW * (c.p_W - T_WB.p);
  Vec2 uv;
  Mat23 J_C;
  if (!camera.project(T_CB * p_B, uv, J_C)) return false;
  out.r = c.uv - uv;
  const Mat23 J_B = J_C * T_CB.R;
  const Mat23 J_W = J_B * R_BW;
  out.J.leftCols<3>() = J_B * skew(p_B);
  out.J.rightCols<3>() = -J_W;
  out.R = point_cov_scale * J_W * c.cov_W * J_W.transpose();
  out.R.diagonal().array() += c.sigma_px * c.sigma_px;
  return true;
}

}  // namespace pirvs
