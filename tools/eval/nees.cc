#include "tools/eval/nees.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/math/so3.h"

namespace pirvs::tools {
namespace {

constexpr double kTruthGap_s = 0.02;  // velocity is not made up inside a longer gap

// The truth at t_s, linear between its neighbours; false outside it or inside a gap.
bool truth_at(const Trajectory& truth, double t_s, TrajectoryPose& out) {
  const auto by_time = [](const TrajectoryPose& pose, double t) { return pose.t_s < t; };
  const auto after = std::lower_bound(truth.poses.begin(), truth.poses.end(), t_s, by_time);
  if (after == truth.poses.end()) return false;
  if (after == truth.poses.begin()) {
    out = *after;
    return after->t_s - t_s < 1e-6;
  }
  const TrajectoryPose &a = *(after - 1), &b = *after;
  if (b.t_s - a.t_s > kTruthGap_s) return false;
  const double s = (t_s - a.t_s) / (b.t_s - a.t_s);
  const double sign = a.q_WB.dot(b.q_WB) < 0 ? -1 : 1;
  out.p_WB = a.p_WB * (1 - s) + b.p_WB * s;
  out.q_WB = (a.q_WB * (1 - s) + b.q_WB * (sign * s)).normalized();
  out.v_WB = a.v_WB * (1 - s) + b.v_WB * s;
  out.b_g = a.b_g * (1 - s) + b.b_g * s;
  out.b_a = a.b_a * (1 - s) + b.b_a * s;
  return true;
}

// The heading alone of the rotation that takes the truth's world to the estimate's.
Mat3 heading(const Mat3& R_EB, const Mat3& R_WB) {
  const Mat3 R_EW = R_EB * R_WB.transpose();
  const double angle = std::atan2(R_EW(1, 0) - R_EW(0, 1), R_EW(0, 0) + R_EW(1, 1));
  return so3_exp(Vec3(0, 0, angle));
}

}  // namespace

Nees evaluate_nees(const std::vector<StateEstimate>& estimates, const TrajectoryPose& first,
                   const Trajectory& truth) {
  Nees out;
  TrajectoryPose at;
  if (!truth.full_state || !truth_at(truth, first.t_s, at)) return out;
  const Mat3 R_EW = heading(rotation_from_quat_xyzw(first.q_WB), rotation_from_quat_xyzw(at.q_WB));
  const Vec3 p_EW = first.p_WB - R_EW * at.p_WB;
  constexpr int kBlock[kNeesParts] = {3, 0, 6, 9, 12};  // in the covariance
  for (const StateEstimate& estimate : estimates) {
    if (!truth_at(truth, estimate.state.t_s, at)) continue;
    NeesFrame frame;
    frame.t = estimate.state.t;
    const Mat3 R_EB = rotation_from_quat_xyzw(estimate.state.q_WB);
    const Mat3 R_EB_truth = R_EW * rotation_from_quat_xyzw(at.q_WB);
    frame.error[kNeesPosition] = R_EW * at.p_WB + p_EW - estimate.state.p_WB;
    frame.error[kNeesAttitude] = so3_log(R_EB.transpose() * R_EB_truth);
    frame.error[kNeesVelocity] = R_EW * at.v_WB - estimate.state.v_WB;
    frame.error[kNeesGyroBias] = at.b_g - estimate.state.b_g;
    frame.error[kNeesAccelBias] = at.b_a - estimate.state.b_a;
    for (int part = 0; part < kNeesParts; ++part) {
      const Mat3 P = estimate.cov.block<3, 3>(kBlock[part], kBlock[part]);
      const Vec3& e = frame.error[part];
      frame.sigma[part] = P.diagonal().cwiseMax(0).cwiseSqrt();
      frame.nees[part] = e.dot(P.ldlt().solve(e));
      out.mean[part] += frame.nees[part];
    }
    out.frames.push_back(frame);
  }
  out.ok = !out.frames.empty();
  for (double& mean : out.mean) mean /= std::max(1.0, double(out.frames.size()));
  return out;
}

NeesBand nees_band(size_t count) {
  constexpr double kQuantile = 1.959963985;
  const double dof = 3.0 * double(std::max<size_t>(count, 1));
  const double spread = kQuantile * std::sqrt(2 / (9 * dof));
  const auto cube = [](double x) { return x * x * x; };
  return {3 * cube(1 - 2 / (9 * dof) - spread), 3 * cube(1 - 2 / (9 * dof) + spread)};
}

}  // namespace pirvs::tools
