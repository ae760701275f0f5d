#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/trig.h"
#include "tools/report/sections.h"

namespace pirvs::tools {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegree = kPi / 180;
constexpr size_t kCirclesMax = 40, kCorners = 24;

Vec3 place_of(const Source& s, const GnssFix& fix) {
  return s.log.local_frame.to_local(
      {fix.latitude_deg * kDegree, fix.longitude_deg * kDegree, fix.height_m});
}

bool is_used(FixGate gate) { return gate == FixGate::kAccepted || gate == FixGate::kVelocity; }
bool has_place(const FixEvent& event) {
  return event.gate != FixGate::kNoFix && event.gate != FixGate::kNotFinite;
}

// What the receiver claims: circles of one sigma.
Series circles(const Source& s) {
  Series out{"their sigma", "truth", {}, {}, true};
  const size_t stride = 1 + s.log.fixes.size() / kCirclesMax;
  for (size_t i = 0; i < s.log.fixes.size(); i += stride) {
    const FixEvent& event = s.log.fixes[i];
    if (!has_place(event)) continue;
    const Vec3 p_E = place_of(s, event.fix);
    for (size_t k = 0; k <= kCorners; ++k) {
      const double angle = 2 * kPi * double(k) / kCorners;
      out.x.push_back(p_E.x() + event.fix.sigma_horizontal_m * std::cos(angle));
      out.y.push_back(p_E.y() + event.fix.sigma_horizontal_m * std::sin(angle));
    }
    out.x.push_back(kNaN);
    out.y.push_back(kNaN);
  }
  return out;
}

// SLAM's own path, put on the Earth where it was first aligned and never again.
Series slam_path(const Source& s) {
  Series out{"SLAM as first aligned", "s2", {}, {}, false};
  SE3 T_EW;
  bool aligned = false;
  for (const FrameReport& frame : s.log.frames) {
    if (!frame.has_pose) continue;
    const SE3& T_WB = frame.pose.state.T_WB;
    if (!aligned) {
      const auto at = std::lower_bound(s.result.fused.begin(), s.result.fused.end(), frame.t,
                                       [](const auto& pose, TimeNs t) { return pose.t < t; });
      if (at == s.result.fused.end() || at->t != frame.t || !at->has_heading) continue;
      T_EW = at->T_EB * T_WB.inverse();
      aligned = true;
    }
    const Vec3 p_E = T_EW * T_WB.p;
    out.x.push_back(p_E.x());
    out.y.push_back(p_E.y());
  }
  return out;
}

std::string map_figure(const Source& s) {
  Figure figure;
  figure.title = "Map";
  figure.x_label = "east [m]";
  figure.y_label = "north [m]";
  figure.height = 560;
  figure.equal_axes = true;
  figure.shared_time = false;
  Series fused{"fused", "path", {}, {}, false};
  for (const FusedPose& pose : s.result.fused) {
    fused.x.push_back(pose.T_EB.p.x());
    fused.y.push_back(pose.T_EB.p.y());
  }
  Dots used{"fixes used", "s3", {}, {}, 1.6}, rejected{"rejected", "x", {}, {}, 2.2};
  for (const FixEvent& event : s.log.fixes) {
    if (!has_place(event)) continue;
    const Vec3 p_E = place_of(s, event.fix);
    Dots& dots = is_used(event.gate) ? used : rejected;
    dots.x.push_back(p_E.x());
    dots.y.push_back(p_E.y());
  }
  figure.series = {circles(s), slam_path(s), fused};
  figure.dots = {used};
  if (!rejected.x.empty()) figure.dots.push_back(rejected);
  return card(figure.svg());
}

// How far each fix is from where the fused pose has the antenna.
std::string gate_figure(const Source& s) {
  Figure figure = time_figure(s, "Fixes against the fused antenna", "m");
  figure.from_zero = true;
  Dots used{"used", "s3", {}, {}, 1.6}, rejected{"rejected", "x", {}, {}, 2.2};
  const Vec3& p_BA = s.recording.calibration.gnss.p_BA;
  for (const FixEvent& event : s.log.fixes) {
    const TimeNs t = event.fix.t + s.recording.calibration.gnss.time_offset_ns;
    const auto at = std::lower_bound(s.result.fused.begin(), s.result.fused.end(), t,
                                     [](const auto& pose, TimeNs time) { return pose.t < time; });
    if (at == s.result.fused.end() || !has_place(event)) continue;
    Dots& dots = is_used(event.gate) ? used : rejected;
    dots.x.push_back(s.time(t));
    dots.y.push_back((place_of(s, event.fix) - at->T_EB * p_BA).norm());
  }
  Series sigma{"sigma of the fused position", "path", {}, {}, false};
  for (const FusedPose& pose : s.result.fused) {
    sigma.x.push_back(s.time(pose.t));
    sigma.y.push_back(std::sqrt(pose.cov.block<3, 3>(3, 3).trace()));
  }
  figure.series = {sigma};
  figure.dots = {used};
  if (!rejected.x.empty()) figure.dots.push_back(rejected);
  return card(figure.svg());
}

}  // namespace

std::string gnss_section(const Source& s) {
  if (s.result.fused.empty()) return "";
  return heading("On the Earth, with GNSS") + map_figure(s) + gate_figure(s);
}

}  // namespace pirvs::tools
