#include "modules/mapping/window_prior.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/math/so3.h"
#include "modules/state/body_state.h"

namespace pirvs {
namespace {

double information(double sigma) { return 1.0 / (sigma * sigma); }

struct Pair {
  Mat15 H_aa, H_ab, H_bb;
  Vec15 g_a, g_b;
};

void add_wheels(const WheelLink& link, const BodyState& a, const BodyState& b, Pair& pair) {
  Vec3x15 J_a, J_b;
  link_jacobians(link, a, b, J_a, J_b);
  const Vec3 Wr = link.information * link_residual(link, a, b);
  const Vec3x15 WJ_b = link.information * J_b;
  pair.H_aa += J_a.transpose() * (link.information * J_a);
  pair.H_ab += J_a.transpose() * WJ_b;
  pair.H_bb += J_b.transpose() * WJ_b;
  pair.g_a -= J_a.transpose() * Wr;
  pair.g_b -= J_b.transpose() * Wr;
}

// Vision's relative pose of b in a. Its residual is chosen so that the gradient of the whole pair
// vanishes at the adjusted states: at the optimum, vision's gradient is minus that of the IMU link
// and the prior.
void add_relative_pose(const BodyState& a, const BodyState& b, const Mat6& vision, Pair& pair) {
  Mat6 J_a = Mat6::Zero(), J_b = Mat6::Zero();
  const Mat3 R_aW = a.T_WB.R.transpose();
  J_a.block<3, 3>(0, 0) = -b.T_WB.R.transpose() * a.T_WB.R;
  J_b.block<3, 3>(0, 0).setIdentity();
  J_a.block<3, 3>(3, 0) = skew(R_aW * (b.T_WB.p - a.T_WB.p));
  J_a.block<3, 3>(3, 3) = -R_aW;
  J_b.block<3, 3>(3, 3) = R_aW;
  const Mat6 J_inverse = J_a.partialPivLu().inverse();
  Mat6 W = J_inverse.transpose() * vision * J_inverse;
  W.diagonal().array() += 1.0;  // where vision saw nothing: a metre, a radian
  pair.H_aa.topLeftCorner<6, 6>() += J_a.transpose() * W * J_a;
  pair.H_ab.topLeftCorner<6, 6>() += J_a.transpose() * W * J_b;
  pair.H_bb.topLeftCorner<6, 6>() += J_b.transpose() * W * J_b;
  const Mat6 J_a_transposed = J_a.transpose();
  const Vec6 Wr = J_a_transposed.partialPivLu().solve(pair.g_a.head<6>());
  pair.g_a.head<6>().setZero();
  pair.g_b.head<6>() -= J_b.transpose() * Wr;
}

// Place and heading are known only by the map, whose fixed keyframes say them again: what the prior
// holds of them is forgotten (velocity turns with the heading, so that only the gauge goes), and a
// loose anchor where the keyframe is now stands in for a window that no fixed keyframe sees.
void forget_gauge(const MappingParams& params, WindowPrior& prior) {
  const Mat3 R_BW = prior.mean.T_WB.R.transpose();
  Eigen::Matrix<double, 15, 4> U = Eigen::Matrix<double, 15, 4>::Zero();
  U.block<3, 1>(0, 0) = R_BW.col(2);
  U.block<3, 1>(6, 0) = Vec3(-prior.mean.v_WB.y(), prior.mean.v_WB.x(), 0);
  U.block<3, 3>(3, 1).setIdentity();
  const Eigen::Matrix<double, 15, 4> LU = prior.information * U;
  const Eigen::Matrix<double, 4, 4> core =
      (U.transpose() * LU + 1e-9 * Eigen::Matrix<double, 4, 4>::Identity()).inverse();
  prior.gradient -= (LU * core * (U.transpose() * prior.gradient)).eval();
  prior.information -= (LU * core * LU.transpose()).eval();
  prior.information.block<3, 3>(0, 0) +=
      information(params.anchor_sigma_rad) * R_BW.col(2) * R_BW.col(2).transpose();
  prior.information.diagonal().segment<3>(3).array() += information(params.anchor_sigma_m);
}

}  // namespace

WindowPrior start_prior(uint32_t sequence, const BodyState& first, const MappingParams& params,
                        bool at_rest) {
  WindowPrior prior;
  prior.sequence = sequence;
  prior.mean = first;
  // Place and heading are convention; tilt, velocity and biases are what a start can promise.
  const Vec3 about_axes(information(0.05), information(0.05), information(1e-4));
  const Mat3 R = first.T_WB.R;
  prior.information.block<3, 3>(0, 0) = R.transpose() * about_axes.asDiagonal() * R;
  prior.information.diagonal().segment<3>(3).setConstant(information(1e-4));
  prior.information.diagonal().segment<3>(6).setConstant(information(at_rest ? 0.01 : 0.5));
  prior.information.diagonal().segment<3>(9).setConstant(information(params.start_sigma_gyro_bias));
  prior.information.diagonal().segment<3>(12).setConstant(
      information(params.start_sigma_accel_bias));
  return prior;
}

void move(const SE3& T, WindowPrior& prior) {
  move(T, prior.mean);
  const Mat15 A = error_transform(T);
  prior.information = (A * prior.information * A.transpose()).eval();
  prior.gradient = (A * prior.gradient).eval();
}

Mat6 guessed_vision() {
  Vec6 out;
  out.head<3>().setConstant(information(0.002));
  out.tail<3>().setConstant(information(0.005));
  return out.asDiagonal();
}

WindowPrior advance(const WindowPrior& prior, const BodyState& a, uint32_t sequence_b,
                    const BodyState& b, const Motions* motions, const Mat6& vision,
                    const ImuNoise& noise, const MappingParams& params) {
  WindowPrior next;
  next.sequence = sequence_b;
  next.mean = b;
  if (motions == nullptr) {
    next = start_prior(sequence_b, b, params);
    next.information.block<6, 6>(9, 9) = prior.information.block<6, 6>(9, 9);
    return next;
  }
  Pair pair{prior.information, Mat15::Zero(), Mat15::Zero(),
            prior.gradient - prior.information * boxminus(a, prior.mean), Vec15::Zero()};
  const ImuLink link = make_link(0, 1, *motions->imu, noise);
  const Vec15 Wr = weigh(link, link_residual(link, a, b));
  Mat15 J_a, J_b;
  link_jacobians(link, a, b, J_a, J_b);
  pair.H_aa += J_a.transpose() * weigh(link, J_a);
  const Mat15 WJ_b = weigh(link, J_b);
  pair.H_ab += J_a.transpose() * WJ_b;
  pair.H_bb += J_b.transpose() * WJ_b;
  pair.g_a -= J_a.transpose() * Wr;
  pair.g_b -= J_b.transpose() * Wr;
  if (motions->wheels != nullptr && motions->wheels->holds()) {
    add_wheels(make_link(0, 1, *motions->wheels), a, b, pair);
  }
  add_relative_pose(a, b, vision, pair);

  const Eigen::LDLT<Mat15> H_aa_solver(pair.H_aa);
  next.information = pair.H_bb - pair.H_ab.transpose() * H_aa_solver.solve(pair.H_ab);
  next.gradient = pair.g_b - pair.H_ab.transpose() * H_aa_solver.solve(pair.g_a);
  forget_gauge(params, next);
  next.information = (0.5 * (next.information + next.information.transpose())).eval();
  return next;
}

}  // namespace pirvs
