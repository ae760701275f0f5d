// Where two or more rays meet: the point that fits all views best, with its covariance.
// In      views (T_CW, camera, pixel). Out: p_W, covariance for sigma_px, largest residual.
// Errors  false: fewer than two views, parallel rays, behind a camera, or no convergence.
// Cost    ~1 us for two views, x86-64.
// Source  Hartley, Zisserman, Multiple View Geometry, section 12.2; Gauss-Newton on eq. 6.
#pragma once

#include "core/camera/camera.h"

namespace pirvs {

struct View {
  const Camera* camera;
  SE3 T_CW;
  Vec2 uv;
};

struct Triangulated {
  Vec3 p_W;
  Mat3 cov;
  double residual_px_max;
  double parallax_rad;  // largest angle between the first ray and another
};

bool triangulate(const View* views, int count, double sigma_px, Triangulated& out);

}  // namespace pirvs
