#include "tools/sim/path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tools/sim/wave.h"

namespace pirvs::tools {
namespace {

constexpr int kDegree = 5;
constexpr int kSupport = kDegree + 1;
constexpr int kLead = kDegree / 2;  // knots before the first instant
// Weight of knot i is sum_j kBasis[i][j] u^j / 120, u in [0, 1) inside the interval.
constexpr double kBasis[kSupport][kSupport] = {{1, -5, 10, -10, 5, -1},  {26, -50, 20, 20, -20, 5},
                                               {66, 0, -60, 0, 30, -10}, {26, 50, 20, -20, -20, 10},
                                               {1, 5, 10, 10, 5, -5},    {0, 0, 0, 0, 0, 1}};

// The derivative-th derivative of knot i's weight by u.
double basis(int i, double u, int derivative) {
  double sum = 0;
  double power = 1;
  for (int j = derivative; j < kSupport; ++j) {
    double factor = 1;
    for (int k = 0; k < derivative; ++k) factor *= j - k;
    sum += kBasis[i][j] * factor * power;
    power *= u;
  }
  return sum / 120;
}

Eigen::Quaterniond quaternion(const Vec4& q) { return {q[3], q[0], q[1], q[2]}; }

}  // namespace

void Path::append(const Vec3& p_WB, Vec4 q_WB) {
  if (!knots_.empty() && knots_.back().tail<4>().dot(q_WB) < 0) q_WB = -q_WB;
  Knot knot;
  knot << p_WB, q_WB;
  knots_.push_back(knot);
}

Path Path::flight(uint64_t seed, double rest_s, double duration_s, const Mat3& R_LB) {
  constexpr double kRamp_s = 2.0;  // from rest to full speed
  constexpr double kJitter_m = 0.05;
  constexpr double kJitter_rad = 0.03;
  Random random(seed, 1);
  const Wave wave[] = {random_wave(random, 3.6, 18, 0.15),  random_wave(random, 2.6, 18, 0.15),
                       random_wave(random, 0.6, 8, 0.3),    random_wave(random, 0.5, 7, 0.3),
                       random_wave(random, 0.14, 4.5, 0.5), random_wave(random, 0.12, 5.5, 0.5)};
  Path path;
  path.duration_s_ = duration_s;
  path.spacing_s_ = 0.5;
  const int count = int(std::ceil(duration_s / path.spacing_s_)) + kSupport;
  Vec3 jitter_p = Vec3::Zero();
  Vec3 jitter_r = Vec3::Zero();
  for (int k = 0; k < count; ++k) {
    // A knot moves the path up to three knots before it: rest is rest to the end.
    const double still_s = rest_s > 0 ? rest_s + 2.5 * path.spacing_s_ : 0;
    const double t_s = std::max(0.0, (k - kLead) * path.spacing_s_ - still_s);
    const double s = t_s < kRamp_s ? t_s * t_s / (2 * kRamp_s) : t_s - kRamp_s / 2;
    for (int i = 0; i < 3 && t_s > 0; ++i) {
      jitter_p[i] = kJitter_m * random.normal();
      jitter_r[i] = kJitter_rad * random.normal();
    }
    const Vec3 p_WB = Vec3(wave[0].at(s), wave[1].at(s), 1.6 + wave[2].at(s)) + jitter_p;
    const double yaw = 2 * M_PI / 18 * s + wave[3].at(s) + jitter_r[0];
    const double pitch = wave[4].at(s) + jitter_r[1];
    const double roll = wave[5].at(s) + jitter_r[2];
    const Mat3 R_WL =
        (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(pitch, Vec3::UnitY()) *
         Eigen::AngleAxisd(roll, Vec3::UnitX()))
            .toRotationMatrix();
    path.append(p_WB, Eigen::Quaterniond(Mat3(R_WL * R_LB)).normalized().coeffs());
  }
  return path;
}

Path Path::steady(const SteadyMotion& motion, double duration_s, const Mat3& R_LB) {
  constexpr double kHeight_m = 1.6;
  Path path;
  path.duration_s_ = duration_s;
  path.spacing_s_ = 0.1;
  const int count = int(std::ceil(duration_s / path.spacing_s_)) + kSupport;
  const double still_s = motion.rest_s > 0 ? motion.rest_s + 2.5 * path.spacing_s_ : -1e3;
  double way_s = 0;  // integral of the share of full speed, zero at the start
  for (int k = 0; k < count; ++k) {
    const double u = ((k - kLead - 0.5) * path.spacing_s_ - still_s) / motion.ramp_s;
    const double s = std::clamp(u, 0.0, 1.0);
    if (k > 0) way_s += s * s * (3 - 2 * s) * path.spacing_s_;
    const Mat3 R_WL =
        Eigen::AngleAxisd(motion.turn_rad_s * way_s, Vec3::UnitZ()).toRotationMatrix();
    path.append(Vec3(0, 0, kHeight_m) + motion.v_L * way_s,
                Eigen::Quaterniond(Mat3(R_WL * R_LB)).normalized().coeffs());
  }
  return path;
}

Path Path::along(const Trajectory& trajectory, double duration_s) {
  const auto& poses = trajectory.poses;
  const double begin_s = poses.front().t_s;
  const double whole_s = poses.back().t_s - begin_s;
  Path path;
  path.duration_s_ = duration_s > 0 ? std::min(duration_s, whole_s) : whole_s;
  path.spacing_s_ = 0.1;
  const int count = int(std::ceil(path.duration_s_ / path.spacing_s_)) + kSupport;
  size_t i = 1;
  for (int k = 0; k < count; ++k) {
    const double t_s = begin_s + (k - kLead) * path.spacing_s_;
    while (i + 1 < poses.size() && poses[i].t_s < t_s) ++i;
    const TrajectoryPose& a = poses[i - 1];
    const TrajectoryPose& b = poses[i];
    const double s = std::clamp((t_s - a.t_s) / (b.t_s - a.t_s), 0.0, 1.0);
    const Eigen::Quaterniond q = quaternion(a.q_WB).slerp(s, quaternion(b.q_WB));
    path.append(a.p_WB * (1 - s) + b.p_WB * s, q.coeffs());
  }
  return path;
}

Path Path::through(double duration_s, double spacing_s, const std::function<SE3(double)>& T_WB_at) {
  Path path;
  path.duration_s_ = duration_s;
  path.spacing_s_ = spacing_s;
  const int count = int(std::ceil(duration_s / spacing_s)) + kSupport;
  for (int k = 0; k < count; ++k) {
    const SE3 T_WB = T_WB_at(std::max(0.0, (k - kLead) * spacing_s));
    path.append(T_WB.p, Eigen::Quaterniond(T_WB.R).normalized().coeffs());
  }
  return path;
}

PathState Path::at(double t_s) const {
  const double position = std::clamp(t_s, 0.0, duration_s_) / spacing_s_;
  const int first = std::min(int(position), int(knots_.size()) - kSupport);
  const double u = position - first;
  Knot value[3] = {Knot::Zero(), Knot::Zero(), Knot::Zero()};
  double scale = 1;
  for (int derivative = 0; derivative < 3; ++derivative) {
    for (int i = 0; i < kSupport; ++i) {
      value[derivative] += scale * basis(i, u, derivative) * knots_[size_t(first + i)];
    }
    scale /= spacing_s_;
  }
  PathState state;
  state.p_WB = value[0].head<3>();
  state.v_WB = value[1].head<3>();
  state.a_WB = value[2].head<3>();
  const Vec4 q = value[0].tail<4>();
  const Vec4 dq = value[1].tail<4>();
  // The length's own rate of change drops out of the vector part.
  state.w_B = 2 / q.squaredNorm() * (quaternion(q).conjugate() * quaternion(dq)).vec();
  state.q_WB = q.normalized();
  state.R_WB = quaternion(state.q_WB).toRotationMatrix();
  return state;
}

}  // namespace pirvs::tools
