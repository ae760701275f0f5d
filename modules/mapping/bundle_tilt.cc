// How all frames and points of a bundle tilt as one: the part of the system that belongs to it.
#include <algorithm>

#include <Eigen/LU>

#include "core/math/dense_solver.h"
#include "core/math/so3.h"
#include "modules/mapping/bundle.h"
#include "modules/state/body_state.h"

namespace pirvs {
namespace {

double dot(const double* a, const double* b, size_t n) {
  double sum = 0;
  for (size_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

void Bundle::free_tilt(const Mat2& information) {
  tilt_free_ = true;
  tilt_known_ = information;
}

// Reprojection errors do not change when all frames and points tilt as one: what the IMU links and
// the prior say of that is all there is.
void Bundle::linearize_tilt() {
  std::fill(C_[0], C_[0] + unknowns_, 0.0);
  std::fill(C_[1], C_[1] + unknowns_, 0.0);
  D_ = tilt_known_;
  const Vec2 so_far = so3_log(tilted_).head<2>();
  g_tilt_ = -tilt_known_ * so_far;
  cost_trial_ += so_far.dot(tilt_known_ * so_far);
  using Mat15x2 = Eigen::Matrix<double, 15, 2>;
  const auto add = [this](int at, const Mat15x2& block) {
    for (int axis = 0; axis < 2; ++axis) Eigen::Map<Vec15>(C_[axis] + at) += block.col(axis);
  };
  for (const ImuLink& link : links_) {
    const Frame& a = frames_[static_cast<size_t>(link.from)];
    const Frame& b = frames_[static_cast<size_t>(link.to)];
    Mat15 J_a, J_b;
    link_jacobians(link, a.state, b.state, J_a, J_b);
    const Mat15x2 J = J_a * rigid_motion(a.state, pivot_).leftCols<2>() +
                      J_b * rigid_motion(b.state, pivot_).leftCols<2>();
    Mat15x2 WJ;
    for (int axis = 0; axis < 2; ++axis) WJ.col(axis) = weigh(link, Vec15(J.col(axis)));
    if (a.unknown >= 0) add(a.unknown, J_a.transpose() * WJ);
    add(b.unknown, J_b.transpose() * WJ);
    D_ += J.transpose() * WJ;
    g_tilt_ -= WJ.transpose() * link_residual(link, a.state, b.state);
  }
  if (prior_frame_ < 0) return;
  const Frame& frame = frames_[static_cast<size_t>(prior_frame_)];
  const Mat15x2 M = rigid_motion(frame.state, pivot_).leftCols<2>();
  const Mat15x2 WM = prior_.information * M;
  add(frame.unknown, WM);
  D_ += M.transpose() * WM;
  g_tilt_ +=
      M.transpose() * (prior_.gradient - prior_.information * boxminus(frame.state, prior_.mean));
}

// The tilt that goes with the step in delta_, which it corrects. The factors are those of S.
Vec2 Bundle::solve_tilt(double lambda) {
  const size_t n = static_cast<size_t>(unknowns_);
  Mat2 K = D_;
  K.diagonal() *= 1 + lambda;
  Vec2 g = g_tilt_;
  for (int i = 0; i < 2; ++i) {
    std::copy(C_[i], C_[i] + n, X_[i]);
    solve_factored(factors_, kUnknownsMax, X_[i], n);
  }
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) K(i, j) -= dot(C_[i], X_[j], n);
    g[i] -= dot(C_[i], delta_, n);
  }
  tilt_cov_ = K.inverse();
  const Vec2 tilt = tilt_cov_ * g;
  if (!tilt.allFinite()) return Vec2::Zero();
  for (size_t i = 0; i < n; ++i) delta_[i] -= X_[0][i] * tilt[0] + X_[1][i] * tilt[1];
  return tilt;
}

}  // namespace pirvs
