#include "tools/calib/lens.h"

#include <cmath>

namespace pirvs::tools {
namespace {

// The derivative of the distorted point (x', y') by each coefficient.
using Basis = Eigen::Matrix<double, 2, 4>;

Basis radtan_basis(const Vec3& p_C) {
  const double x = p_C.x() / p_C.z(), y = p_C.y() / p_C.z(), u = x * x + y * y;
  Basis out;
  out << x * u, x * u * u, 2 * x * y, u + 2 * x * x,  //
      y * u, y * u * u, u + 2 * y * y, 2 * x * y;
  return out;
}

Basis kannala_brandt_basis(const Vec3& p_C) {
  const double r = std::hypot(p_C.x(), p_C.y());
  if (!(r > 0)) return Basis::Zero();
  const double theta = std::atan2(r, p_C.z()), u = theta * theta;
  Basis out;
  double power = theta * u;
  for (int i = 0; i < 4; ++i, power *= u) out.col(i) = p_C.head<2>() / r * power;
  return out;
}

}  // namespace

LensVector lens_of(const Camera& camera) {
  LensVector out;
  out << camera.fx, camera.fy, camera.cx, camera.cy, camera.d[0], camera.d[1], camera.d[2],
      camera.d[3];
  return out;
}

void set_lens(const double* lens, Camera& camera) {
  camera.fx = lens[0], camera.fy = lens[1];
  camera.cx = lens[2], camera.cy = lens[3];
  for (int i = 0; i < 4; ++i) camera.d[i] = lens[4 + i];
}

bool project(const Camera& camera, const Vec3& p_C, Vec2& uv, Mat23& J, Mat28& J_lens) {
  if (!camera.project(p_C, uv, J)) return false;
  const Basis basis =
      camera.model == CameraModel::kPinholeRadtan ? radtan_basis(p_C) : kannala_brandt_basis(p_C);
  J_lens.setZero();
  J_lens(0, 0) = (uv.x() - camera.cx) / camera.fx;
  J_lens(1, 1) = (uv.y() - camera.cy) / camera.fy;
  J_lens(0, 2) = J_lens(1, 3) = 1;
  J_lens.block<1, 4>(0, 4) = camera.fx * basis.row(0);
  J_lens.block<1, 4>(1, 4) = camera.fy * basis.row(1);
  return true;
}

}  // namespace pirvs::tools
