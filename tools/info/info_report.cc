#include "tools/info/info_report.h"

#include <cmath>

#include "tools/report/figure.h"
#include "tools/report/page.h"

namespace pirvs::tools {
namespace {

constexpr int kHalf = 560;

std::string card(const std::string& content) { return "<div class=card>" + content + "</div>\n"; }
std::string two(const Figure& a, const Figure& b) {
  return "<div class=two>" + card(a.svg()) + card(b.svg()) + "</div>\n";
}

Figure half(const std::string& title, const std::string& x, const std::string& y) {
  Figure out;
  out.title = title;
  out.x_label = x;
  out.y_label = y;
  out.width = kHalf;
  out.shared_time = false;
  return out;
}

Figure over_time(const Recording& recording, const std::string& title, const std::string& y) {
  Figure out = half(title, "time [s]", y);
  out.shared_time = true;
  out.x_min = 0;
  out.x_max = recording.duration_s();
  return out;
}

Figure sizes(const Recording& recording, Vec3 ImuSample::*vector, const std::string& title,
             const std::string& unit) {
  Figure out = over_time(recording, title, unit);
  Series series = {"", "s1", {}, {}};
  for (const ImuSample& sample : recording.imu) {
    series.x.push_back(to_seconds(sample.t - recording.frames.front().t));
    series.y.push_back((sample.*vector).norm());
  }
  out.series = {series};
  return out;
}

template <class Rows>
Figure steps(const Recording& recording, const Rows& rows, const std::string& title) {
  Figure out = over_time(recording, title, "ms");
  out.from_zero = true;
  Series series = {"", "s2", {}, {}};
  for (size_t i = 1; i < rows.size(); ++i) {
    series.x.push_back(to_seconds(rows[i].t - recording.frames.front().t));
    series.y.push_back(1e3 * to_seconds(rows[i].t - rows[i - 1].t));
  }
  out.series = {series};
  return out;
}

// From the centre to the nearest side and on to the corner: where a pixel would be without
// distortion, less where it is.
Figure distortion(const Recording& recording) {
  constexpr int kSteps = 100;
  Figure out = half("Angle of view along the diagonal", "pixels from the principal point",
                    "degrees off the axis");
  const char* const labels[] = {"left", "right"};
  const char* const styles[] = {"s1", "s2"};
  for (int c = 0; c < recording.calibration.cameras; ++c) {
    const Camera& k = recording.calibration.camera[c];
    Series lens = {labels[c], styles[c], {}, {}};
    Series plain = {c == 0 ? "a pinhole's" : "", "truth", {}, {}, true};
    const Vec2 corner(k.width - 1 - k.cx, k.height - 1 - k.cy);
    for (int i = 0; i <= kSteps; ++i) {
      const Vec2 off = corner * (double(i) / kSteps);
      Vec3 bearing_C;
      if (!k.unproject(Vec2(k.cx, k.cy) + off, bearing_C)) continue;
      const double across = std::hypot(bearing_C.x(), bearing_C.y());
      lens.x.push_back(off.norm());
      lens.y.push_back(std::atan2(across, bearing_C.z()) * 180 / M_PI);
      plain.x.push_back(off.norm());
      plain.y.push_back(std::atan(std::hypot(off.x() / k.fx, off.y() / k.fy)) * 180 / M_PI);
    }
    if (c == 0) out.series.push_back(plain);
    out.series.push_back(lens);
  }
  return out;
}

Figure misfit(const ImageTurn& turn) {
  Figure out = half("What the turn of the images leaves over of the gyro's",
                    "camera's stamps later than given [ms]", "share");
  out.from_zero = true;
  Series series = {"", "s3", {}, {}};
  for (size_t i = turn.lag_s.size(); i-- > 0;) {
    series.x.push_back(-1e3 * turn.lag_s[i]);
    series.y.push_back(turn.misfit[i]);
  }
  out.series = {series};
  return out;
}

Figure truth(const Recording& recording) {
  Figure out = half("The truth from above", "x [m]", "y [m]");
  out.equal_axes = true;
  out.height = 360;
  Series series = {"", "path", {}, {}};
  for (const TrajectoryPose& pose : recording.truth.poses) {
    series.x.push_back(pose.p_WB.x());
    series.y.push_back(pose.p_WB.y());
  }
  out.series = {series};
  return out;
}

}  // namespace

std::string info_report(const Recording& recording, const InfoFindings& found) {
  const bool good = found.faults.empty();
  std::string body = "<header><div><h1>" + html_escape(recording.folder) +
                     "</h1></div><span class='pill " + (good ? "good" : "bad") + "'>" +
                     (good ? "makes sense" : "would run badly") +
                     "</span><button id=theme>light / dark</button></header>\n";
  for (const std::string& fault : found.faults) {
    body += card("<b>" + html_escape(fault) + "</b>");
  }
  body += card("<pre style='overflow-x:auto'>" + html_escape(found.text) + "</pre>");
  body += two(sizes(recording, &ImuSample::f_B, "Specific force", "m/s^2"),
              sizes(recording, &ImuSample::w_B, "Rate of turn", "rad/s"));
  body += two(steps(recording, recording.frames, "From frame to frame"),
              steps(recording, recording.imu, "From IMU sample to IMU sample"));
  body += two(distortion(recording), misfit(found.turn));
  if (!recording.truth.poses.empty()) body += card(truth(recording).svg());
  return html_page("pirvs info: " + recording.folder, body);
}

}  // namespace pirvs::tools
