#include "tools/calib/spline.h"

#include <cmath>

#include "core/math/so3.h"
#include "tools/calib/solver.h"

namespace pirvs::tools {
namespace {

// Row k: coefficients of u^0 .. u^5 of the weight of knot k, all times 120.
constexpr double kWeights[kSplineOrder][kSplineOrder] = {
    {1, -5, 10, -10, 5, -1},     //
    {26, -50, 20, 20, -20, 5},   //
    {66, 0, -60, 0, 30, -10},    //
    {26, 50, 20, -20, -20, 10},  //
    {1, 5, 10, 10, 5, -5},       //
    {0, 0, 0, 0, 0, 1},
};

}  // namespace

SplineBasis spline_basis(double u, double dt_s) {
  double power[3][kSplineOrder] = {};  // of u, and its derivatives by time
  for (int n = 0; n < kSplineOrder; ++n) {
    power[0][n] = n == 0 ? 1 : power[0][n - 1] * u;
    if (n >= 1) power[1][n] = n * power[0][n - 1] / dt_s;
    if (n >= 2) power[2][n] = n * (n - 1) * power[0][n - 2] / (dt_s * dt_s);
  }
  SplineBasis out;
  for (int d = 0; d < 3; ++d) {
    double sum = 0;
    for (int k = kSplineOrder - 1; k >= 0; --k) {
      double weight = 0;
      for (int n = 0; n < kSplineOrder; ++n) weight += kWeights[k][n] * power[d][n];
      out.b[d][k] = weight / 120;
      out.c[d][k] = sum += out.b[d][k];
    }
  }
  return out;
}

RotationState rotation_at(const double* const* q, const SplineBasis& basis, bool rates) {
  RotationState out;
  Mat3 before = matrix_of(q[0]);
  Mat3 A[kSplineOrder], by_increment[kSplineOrder], inverse[kSplineOrder];
  Vec3 d[kSplineOrder], turned[kSplineOrder];  // turned: A' w, the rate so far
  Vec3 w = Vec3::Zero();
  out.R_TB = before;
  for (int j = 1; j < kSplineOrder; ++j) {
    const Mat3 now = matrix_of(q[j]);
    d[j] = so3_log(before.transpose() * now);
    before = now;
    const double c = basis.c[0][j];
    A[j] = so3_exp(c * d[j]);
    by_increment[j] = c * right_jacobian(c * d[j]);
    inverse[j] = right_jacobian_inverse(d[j]);
    out.R_TB = out.R_TB * A[j];
    if (!rates) continue;
    turned[j] = A[j].transpose() * w;
    w = turned[j] + basis.c[1][j] * d[j];
  }
  if (rates) out.w_B = w;
  // An increment moves with the knot at its end by Jr^-1, with that at its start by -Jl^-1 =
  // -Jr^-T.
  Mat3 P = Mat3::Identity();  // what comes behind increment j, transposed
  for (int k = 0; k < kSplineOrder; ++k) {
    out.dR[k].setZero();
    if (rates) out.dw[k].setZero();
  }
  for (int j = kSplineOrder - 1; j >= 1; --j) {
    const Mat3 dR = P * by_increment[j];
    out.dR[j] += dR * inverse[j];
    out.dR[j - 1] -= dR * inverse[j].transpose();
    if (rates) {
      const Mat3 dw = P * (basis.c[1][j] * Mat3::Identity() + skew(turned[j]) * by_increment[j]);
      out.dw[j] += dw * inverse[j];
      out.dw[j - 1] -= dw * inverse[j].transpose();
    }
    P = P * A[j].transpose();
  }
  out.dR[0] += P;
  return out;
}

}  // namespace pirvs::tools
