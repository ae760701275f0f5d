#include "tools/eval/eval.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace pirvs::tools {
namespace {

constexpr size_t kPosesMin = 10;
constexpr double kTruthGap_s = 0.2;        // no truth is made up inside a longer gap
constexpr double kTiltAfter_s = 10;        // of the first pose: the start should be settled
constexpr double kPairEarly_s = 1e-3;      // a pair may be this much shorter than delta
constexpr double kPairTolerance_s = 0.06;  // a pair further from delta does not count

Mat3 rotation(const Vec4& q) {
  return Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix();
}

// The truth at t_s, linear between its neighbours; false inside a gap.
bool interpolate(const std::vector<TrajectoryPose>& truth, double t_s, EvalPose& out) {
  const auto by_time = [](const TrajectoryPose& pose, double t) { return pose.t_s < t; };
  auto after = std::lower_bound(truth.begin(), truth.end(), t_s, by_time);
  if (after == truth.begin()) ++after;
  const TrajectoryPose& a = *(after - 1);
  const TrajectoryPose& b = *after;
  const double gap_s = b.t_s - a.t_s;
  if (!(gap_s < kTruthGap_s)) return false;
  const double s = (t_s - a.t_s) / gap_s;
  const double sign = a.q_WB.dot(b.q_WB) < 0 ? -1 : 1;
  out.p_truth_WB = a.p_WB * (1 - s) + b.p_WB * s;
  out.q_truth_WB = (a.q_WB * (1 - s) + b.q_WB * (sign * s)).normalized();
  return true;
}

// Moves every matched estimate into the truth's world, by the rotation and shift of least squares.
void align(Evaluation& result) {
  Vec3 mean_E = Vec3::Zero();
  Vec3 mean_W = Vec3::Zero();
  for (const EvalPose& pose : result.matched) {
    mean_E += pose.p_WB;
    mean_W += pose.p_truth_WB;
  }
  mean_E /= double(result.poses);
  mean_W /= double(result.poses);
  Mat3 covariance = Mat3::Zero();
  for (const EvalPose& pose : result.matched) {
    covariance += (pose.p_truth_WB - mean_W) * (pose.p_WB - mean_E).transpose();
  }
  const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double det = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  result.R_WE = svd.matrixU() * Vec3(1, 1, det).asDiagonal() * svd.matrixV().transpose();
  result.p_WE = mean_W - result.R_WE * mean_E;
  for (EvalPose& pose : result.matched) {
    pose.p_WB = result.R_WE * (pose.p_WB - mean_E) + mean_W;
    pose.q_WB = Eigen::Quaterniond(Mat3(result.R_WE * rotation(pose.q_WB))).coeffs();
  }
}

void absolute_error(Evaluation& result) {
  double sum = 0;
  double sum_squares = 0;
  for (size_t i = 0; i < result.poses; ++i) {
    const EvalPose& pose = result.matched[i];
    const double error_m = (pose.p_WB - pose.p_truth_WB).norm();
    sum += error_m;
    sum_squares += error_m * error_m;
    result.ate_max_m = std::max(result.ate_max_m, error_m);
    if (i > 0) result.path_m += (pose.p_truth_WB - result.matched[i - 1].p_truth_WB).norm();
  }
  const double n = double(result.poses);
  const double mean = sum / n;
  double variance = 0;
  for (const EvalPose& pose : result.matched) {
    const double d = (pose.p_WB - pose.p_truth_WB).norm() - mean;
    variance += d * d;
  }
  result.ate_rmse_m = std::sqrt(sum_squares / n);
  result.ate_std_m = std::sqrt(variance / n);
}

// Body frames agree, so the motion over delta is compared in B and needs no alignment.
void relative_error(const std::vector<EvalPose>& matched, Evaluation& result) {
  double sum_m = 0;
  double sum_deg = 0;
  const auto by_time = [](const EvalPose& pose, double t) { return pose.t_s < t; };
  for (const EvalPose& a : matched) {
    const double until_s = a.t_s + result.delta_s - kPairEarly_s;
    const auto found = std::lower_bound(matched.begin(), matched.end(), until_s, by_time);
    if (found == matched.end()) continue;
    const EvalPose& b = *found;
    if (!(std::abs(b.t_s - a.t_s - result.delta_s) < kPairTolerance_s)) continue;
    const Mat3 R_a = rotation(a.q_WB);
    const Mat3 R_truth_a = rotation(a.q_truth_WB);
    const Vec3 d =
        R_a.transpose() * (b.p_WB - a.p_WB) - R_truth_a.transpose() * (b.p_truth_WB - a.p_truth_WB);
    const Mat3 d_R = (R_truth_a.transpose() * rotation(b.q_truth_WB)).transpose() *
                     (R_a.transpose() * rotation(b.q_WB));
    const double cosine = std::clamp((d_R.trace() - 1) / 2, -1.0, 1.0);
    const double angle_deg = std::acos(cosine) * (180 / M_PI);
    sum_m += d.squaredNorm();
    sum_deg += angle_deg * angle_deg;
    ++result.rpe_pairs;
  }
  const double n = double(result.rpe_pairs);
  result.rpe_m = std::sqrt(sum_m / n);  // no pair: NaN, and printed so
  result.rpe_deg = std::sqrt(sum_deg / n);
}

// Heading and place are free, gravity is not.
void tilt_error(const std::vector<EvalPose>& matched, Evaluation& result) {
  result.tilt_at_10_s_deg = std::numeric_limits<double>::quiet_NaN();
  for (const EvalPose& pose : matched) {
    const Vec3 up_B = rotation(pose.q_WB).row(2);
    const Vec3 up_truth_B = rotation(pose.q_truth_WB).row(2);
    const double sine = up_B.cross(up_truth_B).norm();
    const double tilt_deg = std::atan2(sine, up_B.dot(up_truth_B)) * (180 / M_PI);
    const bool is_due = pose.t_s - matched.front().t_s >= kTiltAfter_s;
    if (is_due && std::isnan(result.tilt_at_10_s_deg)) result.tilt_at_10_s_deg = tilt_deg;
    result.tilt_at_end_deg = tilt_deg;
    result.tilt_max_deg = std::max(result.tilt_max_deg, tilt_deg);
  }
}

}  // namespace

Evaluation evaluate(const Trajectory& estimate, const Trajectory& truth, double delta_s) {
  Evaluation result;
  result.delta_s = delta_s;
  const double begin_s = truth.poses.front().t_s;
  const double end_s = truth.poses.back().t_s;
  size_t inside = 0;
  for (const TrajectoryPose& pose : estimate.poses) {
    if (!(pose.t_s > begin_s && pose.t_s < end_s)) continue;
    ++inside;
    EvalPose matched{pose.t, pose.t_s, pose.p_WB, pose.q_WB, Vec3::Zero(), Vec4::Zero()};
    if (interpolate(truth.poses, pose.t_s, matched)) result.matched.push_back(matched);
  }
  result.poses = result.matched.size();
  result.ok = inside >= kPosesMin && result.poses >= 3;
  if (!result.ok) {
    if (inside < kPosesMin) result.poses = inside;
    return result;
  }
  result.duration_s = result.matched.back().t_s - result.matched.front().t_s;
  relative_error(result.matched, result);
  tilt_error(result.matched, result);
  align(result);
  absolute_error(result);
  return result;
}

std::string to_line(const Evaluation& r) {
  char line[256];
  if (!r.ok) {
    std::snprintf(line, sizeof line, "too few poses: %zu", r.poses);
    return line;
  }
  const double rpe_m = r.rpe_pairs ? r.rpe_m : std::abs(r.rpe_m);  // "nan", never "-nan"
  const double rpe_deg = r.rpe_pairs ? r.rpe_deg : std::abs(r.rpe_deg);
  std::snprintf(line, sizeof line,
                "poses %zu of %.1f s, path %.1f m  ATE rmse %.4f m std %.4f max %.4f  "
                "RPE(%g s) t %.4f m r %.4f deg",
                r.poses, r.duration_s, r.path_m, r.ate_rmse_m, r.ate_std_m, r.ate_max_m, r.delta_s,
                rpe_m, rpe_deg);
  return line;
}

}  // namespace pirvs::tools
