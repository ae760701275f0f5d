#include "tools/sim/wheel_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/math/so3.h"
#include "core/math/trig.h"
#include "tools/dataset/input_error.h"
#include "tools/sim/random.h"
#include "tools/sim/sensor_folder.h"

namespace pirvs::tools {
namespace {

constexpr double kFirst_s = 0.007;
constexpr const char* kKinds[] = {"left_right", "twist", "ticks", "steering"};
constexpr const char* kHeadings[] = {"left [m/s],right [m/s]", "speed [m/s],turn [rad/s]",
                                     "left [ticks],right [ticks]", "speed [m/s],steering [rad]"};

struct Going {
  double forward_m_s, turn_rad_s;
};

// Of V's origin, from one pose of the truth to the next.
Going going_at(const Trajectory& truth, const SE3& T_BV, double t_s) {
  const auto& poses = truth.poses;
  const TimeNs t = poses.front().t + from_seconds(t_s);
  const auto after = std::lower_bound(poses.begin(), poses.end(), t,
                                      [](const auto& pose, TimeNs time) { return pose.t < time; });
  const size_t i = std::clamp<size_t>(size_t(after - poses.begin()), 1, poses.size() - 1);
  const auto vehicle = [&](const TrajectoryPose& pose) {
    return SE3{rotation_from_quat_xyzw(pose.q_WB), pose.p_WB} * T_BV;
  };
  const SE3 a = vehicle(poses[i - 1]), b = vehicle(poses[i]);
  const double dt_s = to_seconds(poses[i].t - poses[i - 1].t);
  const Vec3 turn_V = so3_log(a.R.transpose() * b.R) / dt_s;
  const Mat3 R = a.R * so3_exp(0.5 * dt_s * turn_V);
  return {(R.transpose() * (b.p - a.p)).x() / dt_s, turn_V.z()};
}

std::string sensor_yaml(const WheelOptions& o, const SE3& T_BV) {
  std::string out = "sensor_type: wheels\ncomment: simulated\nkind: " + o.kind +
                    "\n# of the vehicle: x forward, y left, z up, from the axle that does not steer"
                    "\nT_BS:\n  cols: 4\n  rows: 4\n  data: [";
  char text[256];
  for (int i = 0; i < 3; ++i) {
    std::snprintf(text, sizeof text, "%.12g, %.12g, %.12g, %.12g,\n         ", T_BV.R(i, 0),
                  T_BV.R(i, 1), T_BV.R(i, 2), T_BV.p[i]);
    out += text;
  }
  std::snprintf(text, sizeof text,
                "0.0, 0.0, 0.0, 1.0]\ntrack: %.9g\nwheelbase: %.9g\nradius: %.9g\n"
                "ticks_per_turn: %d\ntime_offset: 0.0\n",
                o.track_m, o.wheelbase_m, o.radius_m, o.ticks_per_turn);
  return out + text;
}

}  // namespace

void write_wheels(const WheelOptions& o, const Trajectory& truth, const SE3& T_BV, uint64_t seed,
                  const std::string& folder) {
  const auto kind = std::find(std::begin(kKinds), std::end(kKinds), o.kind) - std::begin(kKinds);
  if (kind == std::ptrdiff_t(std::size(kKinds))) {
    throw InputError("unknown wheels '" + o.kind + "'", "--wheels",
                     "use left_right, twist, ticks or steering");
  }
  if (truth.poses.size() < 2) throw InputError("no path", folder, "give a longer ground truth");
  Random random(seed, 50);
  std::string rows = std::string("#timestamp [ns],") + kHeadings[kind] + "\n";
  const double end_s = to_seconds(truth.poses.back().t - truth.poses.front().t);
  const double tick_m = 2 * kPi * o.radius_m / o.ticks_per_turn;
  double left_m = 0, right_m = 0;  // so far, for counters
  for (int k = 0;; ++k) {
    const double t_s = kFirst_s + k / o.rate_hz;
    if (t_s > end_s) break;
    // Both wheels, from what the vehicle does: half a period ago, for what counters have summed.
    const auto speeds = [&](double at_s, double& left, double& right) {
      const Going going = going_at(truth, T_BV, std::max(0.0, at_s));
      left = going.forward_m_s - going.turn_rad_s * o.track_m / 2;
      right = going.forward_m_s + going.turn_rad_s * o.track_m / 2;
      if (at_s >= o.spin_from_s && at_s < o.spin_from_s + o.spin_for_s) left += o.spin_m_s;
      left *= o.scale;
      right *= o.scale;
    };
    double left = 0, right = 0;
    speeds(t_s, left, right);
    const double noise[2] = {o.sigma_m_s * random.normal(), o.sigma_m_s * random.normal()};
    left += noise[0];
    right += noise[1];
    double value[2] = {left, right};
    const double speed = (left + right) / 2, turn = (right - left) / o.track_m;
    if (o.kind == "twist") {
      value[0] = speed;
      value[1] = turn;
    } else if (o.kind == "steering") {
      value[0] = speed;
      value[1] = std::abs(speed) > 1e-3 ? std::atan(o.wheelbase_m * turn / speed) : 0;
    } else if (o.kind == "ticks") {
      constexpr int kSteps = 10;
      for (int i = 0; i < kSteps && k > 0; ++i) {
        double l = 0, r = 0;
        speeds(t_s - (i + 0.5) / kSteps / o.rate_hz, l, r);
        left_m += l / kSteps / o.rate_hz;
        right_m += r / kSteps / o.rate_hz;
      }
      value[0] = std::floor(left_m / tick_m);
      value[1] = std::floor(right_m / tick_m);
    }
    char text[96];
    std::snprintf(text, sizeof text, "%lld,%.9g,%.9g\n",
                  static_cast<long long>(truth.poses.front().t + from_seconds(t_s)), value[0],
                  value[1]);
    rows += text;
  }
  write_sensor_folder(folder, rows, sensor_yaml(o, T_BV));
}

}  // namespace pirvs::tools
