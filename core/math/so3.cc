#include "core/math/so3.h"

#include <cmath>

#include "core/base/assert.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

// Below this squared angle (0.2 rad) five terms of a series are exact to double precision, and
// above it the closed forms lose at most two digits.
constexpr double kSeriesBelow = 0.04;

struct Coefficients {
  double a;  // sin t / t
  double b;  // (1 - cos t) / t^2
  double c;  // (t - sin t) / t^3
};

Coefficients coefficients(double t2) {
  if (t2 < kSeriesBelow) {
    return {1.0 - t2 / 6 * (1.0 - t2 / 20 * (1.0 - t2 / 42 * (1.0 - t2 / 72 * (1.0 - t2 / 110)))),
            0.5 * (1.0 - t2 / 12 * (1.0 - t2 / 30 * (1.0 - t2 / 56 * (1.0 - t2 / 90)))),
            (1.0 - t2 / 20 * (1.0 - t2 / 42 * (1.0 - t2 / 72 * (1.0 - t2 / 110)))) / 6};
  }
  const double t = std::sqrt(t2);
  double s, c;  // of the half angle: 1 - cos t = 2 s^2 has no cancellation
  sincos(0.5 * t, s, c);
  const double sin_t = 2.0 * s * c;
  return {sin_t / t, 2.0 * s * s / t2, (t - sin_t) / (t2 * t)};
}

// I + alpha skew(v) + beta skew(v)^2, with skew(v)^2 = v v' - v'v I.
Mat3 rodrigues(const Vec3& v, double alpha, double beta) {
  const double x = v.x(), y = v.y(), z = v.z();
  const double bxy = beta * x * y, bxz = beta * x * z, byz = beta * y * z;
  Mat3 M;
  M << 1.0 - beta * (y * y + z * z), bxy - alpha * z, bxz + alpha * y,  //
      bxy + alpha * z, 1.0 - beta * (x * x + z * z), byz - alpha * x,   //
      bxz - alpha * y, byz + alpha * x, 1.0 - beta * (x * x + y * y);
  return M;
}

}  // namespace

Mat3 skew(const Vec3& a) {
  Mat3 M;
  M << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return M;
}

Mat3 so3_exp(const Vec3& phi) {
  const Coefficients k = coefficients(phi.squaredNorm());
  return rodrigues(phi, k.a, k.b);
}

Vec3 so3_log(const Mat3& R) {
  const Vec4 q = quat_xyzw(R);
  const Vec3 v = q.head<3>();
  const double n = v.norm();
  // angle / n with n = sin(angle / 2), w = cos(angle / 2) >= 0; 2 is the limit at zero.
  const double scale = n > 0.0 ? 2.0 * arctan2(n, q.w()) / n : 2.0;
  return scale * v;
}

Mat3 right_jacobian(const Vec3& phi) {
  const Coefficients k = coefficients(phi.squaredNorm());
  return rodrigues(phi, -k.b, k.c);
}

Mat3 right_jacobian_inverse(const Vec3& phi) {
  const double t2 = phi.squaredNorm();
  double k;  // (1 - (t / 2) cot(t / 2)) / t^2
  if (t2 < kSeriesBelow) {
    k = 1.0 / 12 +
        t2 * (1.0 / 720 + t2 * (1.0 / 30240 + t2 * (1.0 / 1209600 + t2 * (1.0 / 47900160))));
  } else {
    const double half = 0.5 * std::sqrt(t2);
    double s, c;
    sincos(half, s, c);
    k = (1.0 - half * c / s) / t2;
  }
  return rodrigues(phi, 0.5, k);
}

Mat3 orthonormalized(const Mat3& R) { return rotation_from_quat_xyzw(quat_xyzw(R)); }

Vec4 quat_xyzw(const Mat3& R) {
  // 4 w^2 - 1, 4 x^2 - 1, ...: the largest component gives the others without cancellation.
  const double trace = R.trace();
  Vec4 q;
  if (trace > R.diagonal().maxCoeff()) {
    q << R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1), 1.0 + trace;
  } else {
    int i = 0;
    if (R(1, 1) > R(0, 0)) i = 1;
    if (R(2, 2) > R(i, i)) i = 2;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    q[i] = 1.0 + R(i, i) - R(j, j) - R(k, k);
    q[j] = R(j, i) + R(i, j);
    q[k] = R(k, i) + R(i, k);
    q[3] = R(k, j) - R(j, k);
  }
  const double scale = 1.0 / q.norm();
  return (q.w() < 0.0 ? -scale : scale) * q;
}

Mat3 rotation_from_quat_xyzw(const Vec4& q) {
  const double n2 = q.squaredNorm();
  PIRVS_ASSERT(n2 > 0.0);
  // R = I + 2 w skew(v) + 2 skew(v)^2 for a unit quaternion.
  const double scale = 2.0 / n2;
  return rodrigues(q.head<3>(), scale * q.w(), scale);
}

}  // namespace pirvs
