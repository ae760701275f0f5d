#include "core/camera/camera.h"

#include <cmath>

#include "core/math/trig.h"

namespace pirvs {
namespace {

constexpr double kDepthMin_m = 1e-6;  // keeps x / z and its powers finite
constexpr int kNewtonMax = 10;        // three or four are usual
constexpr double kNewtonStep = 1e-9;  // quadratic: the step after one this small is below 1e-16

// r (1 + k1 u + k2 u^2), u = r^2, has risen all the way from zero to u: its derivative
// q(u) = 1 + 3 k1 u + 5 k2 u^2 is positive, and u is not beyond a pair of roots.
bool radtan_monotonic(const double* d, double u) {
  const double b = 3.0 * d[0], a = 5.0 * d[1];
  if (!(1.0 + u * (b + u * a) > 0.0)) return false;
  const bool dips = a > 0.0 && b < 0.0 && b * b >= 4.0 * a;
  return !dips || 2.0 * a * u < -b;
}

// Distorts the normalized point (x, y) and differentiates: J = [xx xy; xy yy] is symmetric.
struct Radtan {
  double x, y;
  double xx, xy, yy;
};

Radtan radtan(const double* d, double x, double y) {
  const double k1 = d[0], k2 = d[1], p1 = d[2], p2 = d[3];
  const double u = x * x + y * y;
  const double radial = 1.0 + u * (k1 + u * k2);
  const double slope = 2.0 * (k1 + 2.0 * u * k2);  // d radial / d x = slope x
  Radtan out;
  out.x = x * radial + 2.0 * p1 * x * y + p2 * (u + 2.0 * x * x);
  out.y = y * radial + p1 * (u + 2.0 * y * y) + 2.0 * p2 * x * y;
  out.xx = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
  out.xy = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
  out.yy = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  return out;
}

template <bool kJacobian>
bool project_radtan(const Camera& camera, const Vec3& p_C, Vec2& uv, Mat23* J) {
  if (!(p_C.z() > kDepthMin_m)) return false;
  const double inv_z = 1.0 / p_C.z();
  const double x = p_C.x() * inv_z, y = p_C.y() * inv_z;
  if (!radtan_monotonic(camera.d, x * x + y * y)) return false;
  const Radtan m = radtan(camera.d, x, y);
  uv << camera.fx * m.x + camera.cx, camera.fy * m.y + camera.cy;
  if constexpr (kJacobian) {
    const double gx = camera.fx * inv_z, gy = camera.fy * inv_z;
    *J << gx * m.xx, gx * m.xy, -gx * (m.xx * x + m.xy * y),  //
        gy * m.xy, gy * m.yy, -gy * (m.xy * x + m.yy * y);
  }
  return true;
}

bool unproject_radtan(const Camera& camera, double xd, double yd, Vec3& bearing_C) {
  double x = xd, y = yd;
  for (int i = 0; i < kNewtonMax; ++i) {
    const Radtan m = radtan(camera.d, x, y);
    const double det = m.xx * m.yy - m.xy * m.xy;
    if (!(det > 0.0)) return false;
    const double ex = xd - m.x, ey = yd - m.y;
    const double inv_det = 1.0 / det;
    const double dx = (m.yy * ex - m.xy * ey) * inv_det;
    const double dy = (m.xx * ey - m.xy * ex) * inv_det;
    x += dx;
    y += dy;
    if (dx * dx + dy * dy > kNewtonStep * kNewtonStep) continue;
    const double u = x * x + y * y;
    if (!radtan_monotonic(camera.d, u)) return false;
    const double scale = 1.0 / std::sqrt(1.0 + u);
    bearing_C << x * scale, y * scale, scale;
    return true;
  }
  return false;
}

// Image radius over focal length, theta (1 + k1 u + ...) with u = theta^2, and its slope.
struct KannalaBrandt {
  double radius;
  double slope;
};

KannalaBrandt kannala_brandt(const double* d, double theta) {
  const double u = theta * theta;
  return {theta * (1.0 + u * (d[0] + u * (d[1] + u * (d[2] + u * d[3])))),
          1.0 + u * (3.0 * d[0] + u * (5.0 * d[1] + u * (7.0 * d[2] + u * 9.0 * d[3])))};
}

// The slope is positive on all of [0, theta]. It is a quartic in u = theta^2, and lies in the hull
// of its Bernstein coefficients on [0, u]: all positive settles it for nearly every point.
bool kannala_brandt_monotonic(const double* d, double theta, double slope) {
  if (!(slope > 0.0)) return false;
  const double u = theta * theta;
  const double a1 = 3.0 * d[0] * u, a2 = 5.0 * d[1] * u * u, a3 = 7.0 * d[2] * u * u * u;
  if (1.0 + a1 / 4 > 0.0 && 1.0 + a1 / 2 + a2 / 6 > 0.0 &&
      1.0 + a1 * 3 / 4 + a2 / 2 + a3 / 4 > 0.0) {
    return true;
  }
  constexpr int kSteps = 32;
  for (int i = 1; i < kSteps; ++i) {
    if (!(kannala_brandt(d, theta * i / kSteps).slope > 0.0)) return false;
  }
  return true;
}

template <bool kJacobian>
bool project_kannala_brandt(const Camera& camera, const Vec3& p_C, Vec2& uv, Mat23* J) {
  const double x = p_C.x(), y = p_C.y(), z = p_C.z();
  const double r2 = x * x + y * y;
  const double r = std::sqrt(r2);
  if (!(r > 0.0 || z > 0.0)) return false;
  const double theta = arctan2(r, z);
  const KannalaBrandt m = kannala_brandt(camera.d, theta);
  if (!kannala_brandt_monotonic(camera.d, theta, m.slope)) return false;
  const double inv_r = r > 0.0 ? 1.0 / r : 0.0;
  const double scale = r > 0.0 ? m.radius * inv_r : 1.0 / z;  // image over object, across the ray
  uv << camera.fx * scale * x + camera.cx, camera.fy * scale * y + camera.cy;
  if constexpr (kJacobian) {
    // d theta / d r = z / |p|^2, d theta / d z = -r / |p|^2. Along the radius (a, b) the image
    // moves by `radial`, across it by `scale`.
    const double rate = m.slope / (r2 + z * z);
    const double a = x * inv_r, b = y * inv_r;
    const double excess = rate * z - scale;
    *J << camera.fx * (scale + excess * a * a), camera.fx * excess * a * b, -camera.fx * rate * x,
        camera.fy * excess * a * b, camera.fy * (scale + excess * b * b), -camera.fy * rate * y;
  }
  return true;
}

// The angle at which the model has risen to `radius`, before its first fold; < 0: it never does.
// From below in small steps, then by halving: for lenses whose fold lies where Newton would begin.
double angle_below_fold(const double (&d)[4], double radius) {
  constexpr double kStep = 0.01;
  constexpr int kHalvings = 50;
  double low = 0.0;
  for (double theta = kStep; theta <= kPi; theta += kStep) {
    const KannalaBrandt m = kannala_brandt(d, theta);
    if (!(m.slope > 0.0)) return -1.0;
    if (m.radius < radius) {
      low = theta;
      continue;
    }
    double high = theta;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (kannala_brandt(d, middle).radius < radius ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }
  return -1.0;
}

// Newton; < 0: it has not found the angle.
double angle_by_newton(const double (&d)[4], double radius) {
  double theta = radius;
  for (int i = 0; i < kNewtonMax; ++i) {
    const KannalaBrandt m = kannala_brandt(d, theta);
    if (!(m.slope > 0.0)) return -1.0;
    const double step = (radius - m.radius) / m.slope;
    theta += step;
    if (std::fabs(step) > kNewtonStep) continue;
    return theta > kPi || !kannala_brandt_monotonic(d, theta, m.slope) ? -1.0 : theta;
  }
  return -1.0;
}

bool unproject_kannala_brandt(const Camera& camera, double xd, double yd, Vec3& bearing_C) {
  const double radius = std::sqrt(xd * xd + yd * yd);
  double theta = angle_by_newton(camera.d, radius);
  if (!(theta >= 0.0)) theta = angle_below_fold(camera.d, radius);
  if (!(theta >= 0.0)) return false;
  double s, c;
  sincos(theta, s, c);
  const double scale = radius > 0.0 ? s / radius : 1.0;
  bearing_C << xd * scale, yd * scale, c;
  return true;
}

}  // namespace

bool Camera::project(const Vec3& p_C, Vec2& uv) const {
  return model == CameraModel::kPinholeRadtan
             ? project_radtan<false>(*this, p_C, uv, nullptr)
             : project_kannala_brandt<false>(*this, p_C, uv, nullptr);
}

bool Camera::project(const Vec3& p_C, Vec2& uv, Mat23& J) const {
  return model == CameraModel::kPinholeRadtan ? project_radtan<true>(*this, p_C, uv, &J)
                                              : project_kannala_brandt<true>(*this, p_C, uv, &J);
}

bool Camera::unproject(const Vec2& uv, Vec3& bearing_C) const {
  const double x = (uv.x() - cx) / fx, y = (uv.y() - cy) / fy;
  return model == CameraModel::kPinholeRadtan ? unproject_radtan(*this, x, y, bearing_C)
                                              : unproject_kannala_brandt(*this, x, y, bearing_C);
}

bool Camera::in_image(const Vec2& uv, double border_px) const {
  return uv.x() >= border_px && uv.y() >= border_px && uv.x() <= width - 1 - border_px &&
         uv.y() <= height - 1 - border_px;
}

}  // namespace pirvs
