#include "tools/run/fused.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/math/so3.h"
#include "core/math/trig.h"

namespace pirvs::tools {
namespace {

constexpr double kDegree = kPi / 180;

// The truth in the frame of the fused poses, at any time.
class Truth {
 public:
  Truth(const Recording& recording, const LocalFrame& frame) : poses_(recording.truth.poses) {
    const GnssSensor& sensor = recording.gnss_sensor;
    const Geodetic origin = {sensor.truth_latitude_deg * kDegree,
                             sensor.truth_longitude_deg * kDegree, sensor.truth_height_m};
    T_EW_.R = frame.turn_from(origin) * so3_exp(Vec3(0, 0, sensor.truth_heading_deg * kDegree));
    T_EW_.p = frame.to_local(origin);
  }
  bool at(TimeNs t, SE3& out) const {
    const auto after =
        std::lower_bound(poses_.begin(), poses_.end(), t,
                         [](const auto& pose, TimeNs time) { return pose.t < time; });
    if (after == poses_.end() || (after == poses_.begin() && after->t != t)) return false;
    const TrajectoryPose& b = *after;
    const TrajectoryPose& a = after == poses_.begin() ? b : *(after - 1);
    const double s = b.t == a.t ? 0 : double(t - a.t) / double(b.t - a.t);
    const Mat3 Ra = rotation_from_quat_xyzw(a.q_WB), Rb = rotation_from_quat_xyzw(b.q_WB);
    out =
        T_EW_ * SE3{Ra * so3_exp(s * so3_log(Ra.transpose() * Rb)), a.p_WB + s * (b.p_WB - a.p_WB)};
    return true;
  }

 private:
  const std::vector<TrajectoryPose>& poses_;
  SE3 T_EW_;
};

double fixes_rmse(const Recording& recording, const Truth& truth, const LocalFrame& frame) {
  double sum = 0;
  size_t count = 0;
  for (const GnssFix& fix : recording.gnss) {
    SE3 T_EB;
    const GnssAntenna& antenna = recording.calibration.gnss;
    if (!truth.at(fix.t + antenna.time_offset_ns, T_EB)) continue;
    if (fix.type < GnssFixType::k3d) continue;
    const Vec3 p_E =
        frame.to_local({fix.latitude_deg * kDegree, fix.longitude_deg * kDegree, fix.height_m});
    sum += (p_E - T_EB * antenna.p_BA).squaredNorm();
    ++count;
  }
  return std::sqrt(sum / double(std::max<size_t>(count, 1)));
}

void append(std::string& out, const char* format, double value) {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  out += text;
}

}  // namespace

std::vector<FusedPose> in_order(const std::vector<FusedPose>& poses) {
  std::vector<FusedPose> out;
  for (const FusedPose& pose : poses) {
    if (pose.health == FusionHealth::kNone) continue;
    if (out.empty() || pose.t > out.back().t) out.push_back(pose);
  }
  return out;
}

FusedResult evaluate_fused(const Recording& recording, const std::vector<FusedPose>& poses,
                           const LocalFrame& frame) {
  FusedResult out;
  if (!recording.gnss_sensor.has_truth || recording.truth.poses.size() < 2) return out;
  const Truth truth(recording, frame);
  double sum = 0, sum_aligned = 0, sum_heading = 0, sum_nees = 0;
  size_t aligned = 0;
  for (const FusedPose& pose : poses) {
    SE3 T_EB;
    if (!truth.at(pose.t, T_EB)) continue;
    const Vec3 e = pose.T_EB.p - T_EB.p;
    ++out.poses;
    sum += e.squaredNorm();
    out.ate_max_m = std::max(out.ate_max_m, e.norm());
    out.error_at_end_m = e.norm();
    if (!pose.has_heading) continue;
    const Mat3 cov = pose.cov.block<3, 3>(3, 3);
    ++aligned;
    sum_aligned += e.squaredNorm();
    sum_heading += std::pow((T_EB.R * so3_log(T_EB.R.transpose() * pose.T_EB.R)).z(), 2);
    sum_nees += e.dot(cov.llt().solve(e));
  }
  out.ok = out.poses > 0;
  if (!out.ok) return out;
  const double n = double(std::max<size_t>(aligned, 1));
  out.ate_rmse_m = std::sqrt(sum / double(out.poses));
  out.aligned_rmse_m = std::sqrt(sum_aligned / n);
  out.heading_rmse_deg = std::sqrt(sum_heading / n) / kDegree;
  out.nees_position = sum_nees / n;
  out.fixes_rmse_m = fixes_rmse(recording, truth, frame);
  return out;
}

std::string fused_tum(const std::vector<FusedPose>& poses) {
  std::string out;
  for (const FusedPose& pose : poses) {
    out += tum_line(pose.t, pose.T_EB.p, quat_xyzw(pose.T_EB.R));
  }
  return out;
}

std::string fused_csv(const std::vector<FusedPose>& poses) {
  std::string out =
      "#timestamp [ns],latitude [deg],longitude [deg],height [m],sigma_east [m],sigma_north [m],"
      "sigma_up [m],sigma_yaw [deg],sources,health,confidence,resets\n";
  for (const FusedPose& pose : poses) {
    out += std::to_string(pose.t);
    append(out, ",%.10f", pose.place.latitude_rad / kDegree);
    append(out, ",%.10f", pose.place.longitude_rad / kDegree);
    append(out, ",%.4f", pose.place.height_m);
    for (int i = 3; i < 6; ++i) append(out, ",%.4f", std::sqrt(pose.cov(i, i)));
    const Eigen::Matrix<double, 1, 3> up = pose.T_EB.R.row(2);
    const double var_yaw = (up * pose.cov.topLeftCorner<3, 3>() * up.transpose())(0, 0);
    append(out, ",%.3f", std::sqrt(var_yaw) / kDegree);
    out += (pose.sources & kFromSlam) != 0 ? ",slam" : ",";
    if (pose.sources == (kFromSlam | kFromGnss)) out += "+";
    out += (pose.sources & kFromGnss) != 0 ? "gnss," : ",";
    out += name(pose.health);
    append(out, ",%.2f", double(pose.confidence));
    out += "," + std::to_string(pose.resets) + "\n";
  }
  return out;
}

}  // namespace pirvs::tools
