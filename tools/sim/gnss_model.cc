#include "tools/sim/gnss_model.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/math/geodesy.h"
#include "core/math/so3.h"
#include "core/math/trig.h"
#include "tools/dataset/input_error.h"
#include "tools/sim/random.h"
#include "tools/sim/sensor_folder.h"

namespace pirvs::tools {
namespace {

constexpr double kDegree = kPi / 180;
constexpr double kFirst_s = 0.013;
constexpr double kVerticalShare = 1.5;

struct Kind {
  const char* name;
  const char* fix;
  double rate_hz, sigma_m, sigma_m_s;
};
constexpr Kind kKinds[] = {
    {"rtk", "fixed", 5, 0.01, 0.03}, {"float", "float", 5, 0.3, 0.05}, {"spp", "3d", 1, 1.5, 0.1}};

struct Antenna {
  Vec3 p_W, v_W;
};

Antenna antenna_at(const Trajectory& truth, const Vec3& p_BA, double t_s) {
  const auto& poses = truth.poses;
  const TimeNs t = poses.front().t + from_seconds(t_s);
  size_t i = 1;
  const auto after = std::lower_bound(poses.begin(), poses.end(), t,
                                      [](const auto& pose, TimeNs time) { return pose.t < time; });
  i = std::clamp<size_t>(size_t(after - poses.begin()), 1, poses.size() - 1);
  const TrajectoryPose &a = poses[i - 1], &b = poses[i];
  const double step = to_seconds(b.t - a.t), s = to_seconds(t - a.t) / step;
  const Mat3 Ra = rotation_from_quat_xyzw(a.q_WB), Rb = rotation_from_quat_xyzw(b.q_WB);
  const Vec3 turn = so3_log(Ra.transpose() * Rb);
  const Mat3 R = Ra * so3_exp(s * turn);
  const Vec3 v_WB =
      truth.full_state ? Vec3(a.v_WB + s * (b.v_WB - a.v_WB)) : Vec3((b.p_WB - a.p_WB) / step);
  return {a.p_WB + s * (b.p_WB - a.p_WB) + R * p_BA, v_WB + R * (skew(turn / step) * p_BA)};
}

bool within(double t_s, double from_s, double for_s) {
  return t_s >= from_s && t_s < from_s + for_s;
}

// Off a wall: along the middle of the sector and up, by nothing at its edges.
class Sector {
 public:
  Sector(const GnssOptions& options, const Trajectory& truth, const Mat3& R_EW)
      : error_m_(options.multipath_m) {
    if (options.multipath_sector.empty()) return;
    if (options.multipath_sector.size() != 2) {
      throw InputError("a sector is two angles", "--gnss-multipath-sector", "give from and to");
    }
    const double from = options.multipath_sector[0] * kDegree;
    double width = std::fmod(options.multipath_sector[1] * kDegree - from, 2 * kPi);
    if (width <= 0) width += 2 * kPi;
    half_ = width / 2;
    middle_ = from + half_;
    for (const TrajectoryPose& pose : truth.poses) centre_ += R_EW * pose.p_WB;
    centre_ /= double(truth.poses.size());
  }
  Vec3 error(const Vec3& p_E) const {
    const Vec3 way = p_E - centre_;
    const double off = std::remainder(std::atan2(way.y(), way.x()) - middle_, 2 * kPi);
    if (half_ <= 0 || std::abs(off) >= half_) return Vec3::Zero();
    const double share = (1 + std::cos(kPi * off / half_)) / 2;
    return share * error_m_ *
           Vec3(kLevel * std::cos(middle_), kLevel * std::sin(middle_),
                std::sqrt(1 - kLevel * kLevel));
  }

 private:
  static constexpr double kLevel = 0.9;
  double error_m_, half_ = 0, middle_ = 0;
  Vec3 centre_ = Vec3::Zero();
};

std::string sensor_yaml(const GnssOptions& o) {
  char text[640];
  std::snprintf(text, sizeof text,
                "sensor_type: gnss\ncomment: simulated %s receiver\n"
                "T_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, %.9g,\n"
                "         0.0, 1.0, 0.0, %.9g,\n         0.0, 0.0, 1.0, %.9g,\n"
                "         0.0, 0.0, 0.0, 1.0]\n"
                "time_offset: 0.0\nlatency: %.9g\n"
                "# latitude, longitude, height of the truth's origin, degrees from east to its x\n"
                "truth_world: [%.12g, %.12g, %.9g, %.9g]\n",
                o.kind.c_str(), o.antenna[0], o.antenna[1], o.antenna[2], o.latency_s,
                o.latitude_deg, o.longitude_deg, o.height_m, o.heading_deg);
  return text;
}

}  // namespace

void write_gnss(const GnssOptions& options, const Trajectory& truth, uint64_t seed,
                const std::string& folder) {
  const Kind* const kind = std::find_if(std::begin(kKinds), std::end(kKinds),
                                        [&](const Kind& k) { return options.kind == k.name; });
  if (kind == std::end(kKinds)) {
    throw InputError("unknown receiver '" + options.kind + "'", "--gnss", "use rtk, float or spp");
  }
  if (truth.poses.size() < 2) throw InputError("no path", folder, "give a longer ground truth");
  const double rate_hz = options.rate_hz > 0 ? options.rate_hz : kind->rate_hz;
  const double sigma = options.sigma_m > 0 ? options.sigma_m : kind->sigma_m;
  const LocalFrame frame(
      {options.latitude_deg * kDegree, options.longitude_deg * kDegree, options.height_m});
  const Mat3 R_EW = so3_exp(Vec3(0, 0, options.heading_deg * kDegree));
  const Vec3 p_BA(options.antenna[0], options.antenna[1], options.antenna[2]);
  Random random(seed, 40);
  const double way = random.uniform(0, 2 * kPi);
  const Vec3 multipath =
      options.multipath_m * Vec3(0.9 * std::cos(way), 0.9 * std::sin(way), std::sqrt(0.19));
  const Sector sector(options, truth, R_EW);
  std::string rows =
      "#timestamp [ns],latitude [deg],longitude [deg],height [m],v_north [m/s],v_east [m/s],"
      "v_down [m/s],sigma_horizontal [m],sigma_vertical [m],sigma_velocity [m/s],fix\n";
  const auto noise = [&random](double horizontal, double vertical) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return Vec3(horizontal * x, horizontal * y, vertical * z);
  };
  const double end_s = to_seconds(truth.poses.back().t - truth.poses.front().t);
  for (int k = 0;; ++k) {
    const double t_s = kFirst_s + k / rate_hz;
    if (t_s > end_s) break;
    const Vec3 e = noise(sigma, kVerticalShare * sigma),
               e_v = noise(kind->sigma_m_s, kind->sigma_m_s);
    if (within(t_s, options.outage_from_s, options.outage_for_s)) continue;
    const Antenna antenna = antenna_at(truth, p_BA, t_s);
    Vec3 p_E = R_EW * antenna.p_W + e;
    if (within(t_s, options.multipath_from_s, options.multipath_for_s)) p_E += multipath;
    p_E += sector.error(R_EW * antenna.p_W);
    const Vec3 v_E = R_EW * antenna.v_W + e_v;
    const Geodetic place = frame.to_global(p_E);
    char text[256];
    std::snprintf(text, sizeof text, "%lld,%.11f,%.11f,%.5f",
                  static_cast<long long>(truth.poses.front().t + from_seconds(t_s)),
                  place.latitude_rad / kDegree, place.longitude_rad / kDegree, place.height_m);
    rows += text;
    // At a place of this size north is that of the origin.
    std::snprintf(text, sizeof text, ",%.5f,%.5f,%.5f", v_E.y(), v_E.x(), -v_E.z());
    rows += options.velocity ? text : ",,,";
    std::snprintf(text, sizeof text, ",%.5g,%.5g", options.claimed * sigma,
                  options.claimed * kVerticalShare * sigma);
    rows += text;
    std::snprintf(text, sizeof text, ",%.5g", kind->sigma_m_s);
    rows += options.velocity ? text : ",";
    rows += std::string(",") + kind->fix + "\n";
  }
  write_sensor_folder(folder, rows, sensor_yaml(options));
}

}  // namespace pirvs::tools
