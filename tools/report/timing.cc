#include <algorithm>
#include <cmath>

#include "tools/report/sections.h"

namespace pirvs::tools {
namespace {

// Mean of each row in the paper's Table II: its own PC, its device (RK3399, two Cortex-A72).
constexpr double kPaperPc_ms[] = {8.7, 0.7, 3.6, 5.9, 18.9};
constexpr double kPaperDevice_ms[] = {30, 3.8, 8.5, 57.2, 99.5};

std::string timing_table(const RunResult& result) {
  std::string out =
      "<div class='card scroll'><table><tr><th>CPU time per stereo frame [ms]</th><th>mean</th>"
      "<th>median</th><th>p95</th><th>p99</th><th>max</th><th class=paper>paper, PC</th>"
      "<th class=paper>paper, device</th></tr>";
  for (size_t i = 0; i < kTimingColumns.size(); ++i) {
    const Statistics& t = result.timing[i];
    out += i + 1 == kTimingColumns.size() ? "<tr class=sum>" : "<tr>";
    out += std::string("<td>") + kTimingColumns[i].label + "</td>";
    for (const double v : {t.mean, t.median, t.p95, t.p99, t.max}) {
      out += format("<td>%.2f</td>", v);
    }
    out += format("<td class=paper>%.1f</td><td class=paper>%.1f</td></tr>", kPaperPc_ms[i],
                  kPaperDevice_ms[i]);
  }
  return out + "</table></div>\n";
}

// Bars as one area: each bin is flat, and as high as the share of the values that fall into it.
Figure histogram(const char* title, const char* unit, const std::vector<double>& values,
                 double range) {
  constexpr int kBins = 120;
  Figure figure;
  figure.title = title;
  figure.x_label = unit;
  figure.y_label = "share [%]";
  figure.width = kHalfWidth;
  figure.height = 250;
  figure.stacked = true;
  figure.shared_time = false;
  figure.x_max = range;
  std::vector<double> share(kBins, 0.0);
  for (const double value : values) {
    const int bin = std::clamp(int(value / range * kBins), 0, kBins - 1);
    share[size_t(bin)] += 100.0 / double(values.size());
  }
  Series bars{"", "s1", {}, {}, false};
  for (int bin = 0; bin < kBins; ++bin) {
    for (const int edge : {bin, bin + 1}) {
      bars.x.push_back(range * edge / kBins);
      bars.y.push_back(share[size_t(bin)]);
    }
  }
  figure.series = {bars};
  return figure;
}

std::string latency_row(const char* what, const LatencySummary& s) {
  std::string out = std::string("<tr><td>") + what + "</td>";
  for (const double ms : {s.min_ms, s.median_ms, s.p99_ms, s.max_ms}) {
    out += format("<td>%.2f</td>", ms);
  }
  return out + "</tr>";
}

// Poses at IMU rate: how late, and how evenly. Only a run in real time knows.
std::string latency_section(const Source& s) {
  if (s.log.poses.empty()) return "";
  Figure latency = time_figure(s, "From an IMU sample to its pose published", "ms");
  latency.width = kHalfWidth;
  latency.height = 250;
  latency.from_zero = true;
  Series series{"latency", "s1", {}, {}, false};
  for (const PublishedPose& pose : s.log.poses) {
    series.x.push_back(s.time(pose.t));
    series.y.push_back(1e3 * to_seconds(pose.t_published - pose.t));
  }
  latency.series = {series};
  const Figure spacing = histogram("Spacing of published poses, the last bar: this and more", "ms",
                                   pose_spacing_ms(s.log), 3 * s.result.pose_spacing.median_ms);
  std::string out = heading("Latency") +
                    "<div class='card scroll'><table><tr><th>[ms]</th><th>min</th><th>median</th>"
                    "<th>p99</th><th>max</th></tr>";
  out += latency_row("IMU sample to pose", s.log.imu_to_pose);
  out += latency_row("mid-exposure to fused pose", s.log.exposure_to_fused);
  out += latency_row("pose to pose", s.result.pose_spacing) + "</table></div>\n";
  return out + "<div class=two>" + card(latency.svg()) + card(spacing.svg()) + "</div>\n";
}

std::string late_table(const Source& s) {
  if (s.log.late.empty()) return "";
  constexpr size_t kRowsMax = 100;
  std::string out =
      "<div class='card scroll'><table class=left><tr><th>time</th><th>late task</th>"
      "<th>steps over budget</th><th>asked too late</th><th>longest step so far</th></tr>";
  for (size_t i = 0; i < std::min(kRowsMax, s.log.late.size()); ++i) {
    const LateEvent& event = s.log.late[i];
    out += format("<tr><td>%.3f s</td><td>%s</td><td>%u</td><td>%u</td><td>%.2f ms</td></tr>",
                  s.time(event.t), event.task.name, unsigned(event.task.overruns),
                  unsigned(event.task.slips), 1e3 * to_seconds(event.task.longest));
  }
  if (s.log.late.size() > kRowsMax) {
    out += format("<tr><td colspan=5>and %zu more</td></tr>", s.log.late.size() - kRowsMax);
  }
  return out + "</table></div>\n";
}

}  // namespace

std::string timing_section(const Source& s) {
  Figure figure = time_figure(s, "CPU time per stereo frame", "ms");
  figure.stacked = true;
  figure.y_quantile = 0.999;
  figure.spans.clear();
  constexpr const char* kStyles[] = {"s1", "s4", "s3", "s2"};
  for (size_t i = 0; i + 1 < kTimingColumns.size(); ++i) {
    Series series{kTimingColumns[i].label, kStyles[i], {}, {}, false};
    for (const FrameReport& frame : s.log.frames) {
      series.x.push_back(s.time(frame.t));
      series.y.push_back(double(frame.*kTimingColumns[i].field));
    }
    figure.series.push_back(series);
  }
  Figure tracks = time_figure(s, "Tracked points", "per frame");
  tracks.from_zero = true;
  const auto all = [&](const char* label, const char* style, auto&& value) {
    Series series{label, style, {}, {}, false};
    for (const FrameReport& frame : s.log.frames) {
      series.x.push_back(s.time(frame.t));
      series.y.push_back(value(frame));
    }
    tracks.series.push_back(series);
  };
  all("tracks, both cameras", "s5", [](const FrameReport& f) { return f.tracks[0] + f.tracks[1]; });
  all("with a map point", "s1", [](const FrameReport& f) { return f.correspondences; });
  all("accepted", "s3", [](const FrameReport& f) { return f.accepted; });
  return heading("Timing") + timing_table(s.result) + card(figure.svg()) + latency_section(s) +
         late_table(s) + heading("Matching") + card(tracks.svg());
}

}  // namespace pirvs::tools
