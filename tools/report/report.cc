#include "tools/report/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/math/so3.h"
#include "tools/report/page.h"
#include "tools/report/sections.h"

namespace pirvs::tools {
namespace {

constexpr const char* kAxisName[3] = {"x", "y", "z"};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr size_t kDotsMax = 1500;

const char* span_style(HealthState state) {
  switch (state) {
    case HealthState::kTracking:
      return "good";
    case HealthState::kDegraded:
      return "warn";
    case HealthState::kLost:
      return "bad";
    case HealthState::kInitializing:
    case HealthState::kCount:
      break;
  }
  return "wait";
}

std::vector<Span> health_spans(const Source& s) {
  std::vector<Span> spans;
  for (const FrameReport& frame : s.log.frames) {
    const char* const style = span_style(frame.pose.health);
    const double t = s.time(frame.t);
    if (spans.empty() || spans.back().style != style) spans.push_back({style, t, t});
    spans.back().to = t;
    if (spans.size() > 1 && spans.back().from == t) spans[spans.size() - 2].to = t;
  }
  spans.erase(std::remove_if(spans.begin(), spans.end(),
                             [](const Span& span) { return span.style == "good"; }),
              spans.end());
  return spans;
}

// One series over the frames; value(frame) may be NaN, and is where there is no pose.
template <class Value>
Series frame_series(const Source& s, const char* label, const char* style, Value&& value) {
  Series out{label, style, {}, {}, false};
  for (const FrameReport& frame : s.log.frames) {
    out.x.push_back(s.time(frame.t));
    out.y.push_back(frame.has_pose ? value(frame) : kNaN);
  }
  return out;
}

template <class Value>
Series truth_series(const Source& s, const char* label, Value&& value) {
  Series out{label, "truth", {}, {}, false};
  for (const TrajectoryPose& pose : s.recording.truth.poses) {
    const double t = s.time(pose.t);
    if (t < 0 || t > s.end_s) continue;
    out.x.push_back(t);
    out.y.push_back(value(pose));
  }
  return out;
}

// ---- trajectory ---------------------------------------------------------------------------------

// Shows the map around the path, but never so much of it that the path becomes small.
Series view_corners(const std::vector<Series>& lines, const Dots& points) {
  constexpr double kShare = 0.3;
  Series corners{"", "none", {}, {}, false};
  const auto corner = [&](auto member, const std::vector<double>& dots, std::vector<double>& out) {
    double lo = std::numeric_limits<double>::infinity();
    double hi = -lo;
    for (const Series& line : lines) {
      for (const double v : line.*member) {
        if (!std::isfinite(v)) continue;
        lo = std::min(lo, v);
        hi = std::max(hi, v);
      }
    }
    std::vector<double> sorted = dots;
    std::sort(sorted.begin(), sorted.end());
    if (!sorted.empty() && lo <= hi) {
      const double most = kShare * std::max(hi - lo, 1.0);
      lo = std::clamp(sorted[sorted.size() / 50], lo - most, lo);
      hi = std::clamp(sorted[sorted.size() - 1 - sorted.size() / 50], hi, hi + most);
    }
    if (lo <= hi) out = {lo, hi};
  };
  corner(&Series::x, points.x, corners.x);
  corner(&Series::y, points.y, corners.y);
  if (corners.x.size() != corners.y.size()) return Series{};
  return corners;
}

std::string trajectory_view(const Source& s, const char* title, int a, int b) {
  Figure figure;
  figure.title = title;
  figure.x_label = std::string(kAxisName[a]) + " [m]";
  figure.y_label = std::string(kAxisName[b]) + " [m]";
  figure.width = kHalfWidth;
  figure.height = 440;
  figure.equal_axes = true;
  figure.shared_time = false;
  Dots points{"map points", "point", {}, {}, 1.1};
  const size_t stride = 1 + s.log.points.size() / kDotsMax;
  for (size_t i = 0; i < s.log.points.size(); i += stride) {
    const Vec3 p_W = s.aligned(s.log.points[i].p_W);
    points.x.push_back(p_W[a]);
    points.y.push_back(p_W[b]);
  }
  Series truth{"ground truth", "truth", {}, {}, false};
  for (const EvalPose& pose : s.result.evaluation.matched) {
    truth.x.push_back(pose.p_truth_WB[a]);
    truth.y.push_back(pose.p_truth_WB[b]);
  }
  Series estimate{"estimate", "path", {}, {}, false};
  for (const TrajectoryPose& pose : s.result.trajectory.poses) {
    const Vec3 p_WB = s.aligned(pose.p_WB);
    estimate.x.push_back(p_WB[a]);
    estimate.y.push_back(p_WB[b]);
  }
  if (!truth.x.empty()) figure.series.push_back(truth);
  figure.series.push_back(estimate);
  figure.series.push_back(view_corners(figure.series, points));
  if (!points.x.empty()) figure.dots.push_back(points);
  if (!estimate.x.empty()) {
    figure.dots.push_back({"start", "start", {estimate.x.front()}, {estimate.y.front()}, 4.5});
    figure.dots.push_back({"end", "end", {estimate.x.back()}, {estimate.y.back()}, 4.5});
  }
  return card(figure.svg());
}

std::string trajectory_section(const Source& s) {
  return "<h2>Trajectory</h2><div class=two>" + trajectory_view(s, "Top view", 0, 1) +
         trajectory_view(s, "Side view", 0, 2) + "</div>\n";
}

// ---- errors -------------------------------------------------------------------------------------

double angle_deg(const Vec4& q, const Vec4& q_truth) {
  const double w = std::min(1.0, std::abs(q.dot(q_truth)));
  return 2 * std::acos(w) * 180 / M_PI;
}

std::string error_section(const Source& s) {
  if (!s.has_truth()) return "";
  Series total{"", "path", {}, {}, false};
  Series axis[3] = {
      {"x", "x", {}, {}, false}, {"y", "y", {}, {}, false}, {"z", "z", {}, {}, false}};
  Series angle{"", "s2", {}, {}, false};
  for (const EvalPose& pose : s.result.evaluation.matched) {
    const double t = s.time(pose.t);
    const Vec3 error_cm = 100 * (pose.p_WB - pose.p_truth_WB);
    total.x.push_back(t);
    total.y.push_back(error_cm.norm());
    for (int i = 0; i < 3; ++i) {
      axis[i].x.push_back(t);
      axis[i].y.push_back(error_cm[i]);
    }
    angle.x.push_back(t);
    angle.y.push_back(angle_deg(pose.q_WB, pose.q_truth_WB));
  }
  total.label = "position error";
  angle.label = "rotation error";
  Figure norm = time_figure(s, "Position error after alignment", "cm");
  norm.from_zero = true;
  norm.series = {total};
  Figure split = time_figure(s, "Position error by axis", "cm");
  split.series = {axis[0], axis[1], axis[2]};
  Figure turn = time_figure(s, "Rotation error after alignment", "deg");
  turn.from_zero = true;
  turn.height = 180;
  turn.series = {angle};
  return heading("Error over time") + card(norm.svg()) + card(split.svg()) + card(turn.svg());
}

// ---- state --------------------------------------------------------------------------------------

std::string axis_figures(const Source& s, const char* title, const char* unit, bool with_truth,
                         Vec3 (*value)(const Source&, const FrameReport&),
                         Vec3 (*truth)(const TrajectoryPose&)) {
  std::string out;
  for (int i = 0; i < 3; ++i) {
    Figure figure =
        time_figure(s, i == 0 ? title : "", std::string(kAxisName[i]) + " [" + unit + "]");
    figure.height = i == 0 ? 168 : 150;
    if (with_truth) {
      figure.series.push_back(
          truth_series(s, "ground truth", [&](const TrajectoryPose& p) { return truth(p)[i]; }));
    }
    figure.series.push_back(frame_series(s, "estimate", kAxisName[i],
                                         [&](const FrameReport& f) { return value(s, f)[i]; }));
    figure.show_legend = i == 0;
    if (i < 2) figure.x_label.clear();
    out += figure.svg();
  }
  return card(out);
}

Vec3 position(const Source& s, const FrameReport& f) { return s.aligned(f.pose.state.T_WB.p); }
Vec3 velocity(const Source& s, const FrameReport& f) { return s.R_WE() * f.pose.state.v_WB; }

std::string bias_figure(const Source& s, const char* title, const char* unit, Vec3 BodyState::*bias,
                        Vec3 TrajectoryPose::*truth) {
  Figure figure = time_figure(s, title, unit);
  figure.width = kHalfWidth;
  figure.height = 250;
  for (int i = 0; i < 3; ++i) {
    figure.series.push_back(frame_series(s, kAxisName[i], kAxisName[i], [&](const FrameReport& f) {
      return (f.pose.state.*bias)[i];
    }));
    if (!s.recording.truth.full_state) continue;
    Series exact = truth_series(s, "", [&](const TrajectoryPose& p) { return (p.*truth)[i]; });
    exact.style = kAxisName[i];
    exact.dashed = true;
    figure.series.push_back(exact);
  }
  return card(figure.svg());
}

std::string state_section(const Source& s) {
  const bool full = s.has_truth() && s.recording.truth.full_state;
  std::string out = heading("Position and velocity");
  out += axis_figures(s, "Position", "m", s.has_truth(), position,
                      [](const TrajectoryPose& p) { return p.p_WB; });
  out += axis_figures(s, "Velocity", "m/s", full, velocity,
                      [](const TrajectoryPose& p) { return p.v_WB; });
  out += heading(s.recording.truth.full_state ? "IMU biases (dashed: ground truth)" : "IMU biases");
  out += "<div class=two>";
  out += bias_figure(s, "Gyroscope", "rad/s", &BodyState::b_g, &TrajectoryPose::b_g);
  out += bias_figure(s, "Accelerometer", "m/s²", &BodyState::b_a, &TrajectoryPose::b_a);
  return out + "</div>\n";
}

// ---- health, counters, memory -------------------------------------------------------------------

std::string health_section(const Source& s) {
  std::string out = heading("Health log");
  out +=
      "<div class='card scroll'><table "
      "class=left><tr><th>time</th><th>state</th><th>event</th></tr>";
  constexpr size_t kRowsMax = 200;
  for (size_t i = 0; i < std::min(kRowsMax, s.log.health.size()); ++i) {
    const HealthEvent& event = s.log.health[i];
    const char* const style = span_style(event.state);
    out += format("<tr><td>%.3f s</td><td><span class='pill %s'>%s</span></td>", s.time(event.t),
                  style, name(event.state));
    out += "<td>" + html_escape(event.what) + "</td></tr>";
  }
  if (s.log.health.empty()) out += "<tr><td colspan=3>no event</td></tr>";
  if (s.log.health.size() > kRowsMax) {
    out += format("<tr><td colspan=3>and %zu more</td></tr>", s.log.health.size() - kRowsMax);
  }
  out += "</table></div>\n";
  out += format("<p>Confidence: mean %.2f, lowest %.2f; %zu frames degraded.</p>\n",
                s.result.confidence.mean, s.result.confidence_min, s.result.frames_degraded);
  out +=
      "<div class='card scroll'><table class=left><tr><th>time</th><th>jump of the pose</th></tr>";
  for (size_t i = 0; i < std::min(kRowsMax, s.result.jumps.size()); ++i) {
    const PoseJump& jump = s.result.jumps[i];
    out += format("<tr><td>%.3f s</td><td>%.3f m, %.2f deg</td></tr>", s.time(jump.t),
                  double(jump.jump_m), double(jump.jump_rad) * 180 / M_PI);
  }
  if (s.result.jumps.empty()) out += "<tr><td colspan=2>none</td></tr>";
  return out + "</table></div>\n";
}

std::string counter_list(const std::vector<Count>& counts) {
  std::string out = "<div class='card columns'>";
  for (const Count& count : counts) {
    out += count.value ? "<div>" : "<div class=zero>";
    out +=
        "<span>" + html_escape(count.name) + format("</span><span>%zu</span></div>", count.value);
  }
  return out + "</div>\n";
}

std::string memory_section(const Source& s) {
  std::string out = heading("Static memory");
  out += "<div class='card scroll'><table class=left>";
  for (const Count& pool : s.log.pools) {
    const double share = double(pool.value) / std::max(1.0, double(s.result.pool_bytes));
    out += "<tr><td style='width:30%'>" + html_escape(pool.name) + "</td>";
    out += format("<td style='width:16%%'>%.1f kB</td>", double(pool.value) / 1024);
    out += format("<td><div class=bar style='width:%.1f%%'></div></td></tr>", 100 * share);
  }
  out += format("<tr class=sum><td>sum</td><td>%.2f MB</td><td></td></tr></table></div>\n",
                double(s.result.pool_bytes) / (1024 * 1024));
  return out;
}

// ---- in 3-D -------------------------------------------------------------------------------------

// Its slider moves the line in all figures (page.cc).
std::string viewer_section(const Source& s, const std::string& viewer) {
  if (viewer.empty()) return "";
  return heading("In space and time") +
         format("<iframe id=viewer title='the run in 3-D' data-t0='%.6f' ", to_seconds(s.t0)) +
         "srcdoc='" + html_escape(viewer) + "'></iframe>\n";
}

// ---- head ---------------------------------------------------------------------------------------

std::string tile(const std::string& value, const char* unit, const std::string& what) {
  return "<div class=tile><b>" + value + "<small>" + unit + "</small></b><span>" + what +
         "</span></div>";
}

std::string head(const RunInfo& info, const RunResult& r) {
  const std::string sequence = info.sequence.substr(
      info.sequence.find_last_not_of('/') == std::string::npos
          ? 0
          : info.sequence.find_last_of('/', info.sequence.find_last_not_of('/')) + 1);
  std::string out = "<header><div><h1>" + html_escape(sequence) + "</h1><div class=sub><code>" +
                    html_escape(info.command) + "</code><br>revision " +
                    html_escape(info.revision) + format(", %.1f s of recording", r.duration_s);
  out += format(" in %.1f s</div></div>", r.wall_s);
  out += r.done ? "<span class='pill good'>tracked to the end</span>"
                : "<span class='pill bad'>lost</span>";
  out += "<button id=theme>light / dark</button></header>\n<div class=tiles>";
  if (r.evaluation.ok) {
    const Evaluation& e = r.evaluation;
    out += tile(format("%.2f", 100 * e.ate_rmse_m), "cm",
                format("ATE rmse, max %.1f cm", 100 * e.ate_max_m));
    out += tile(format("%.2f", 100 * e.rpe_m), "cm",
                format("RPE over %g s, %.2f°", e.delta_s, e.rpe_deg));
    out += tile(format("%.1f", e.path_m), "m", format("path in %.1f s", e.duration_s));
  }
  const Statistics& total = r.timing.back();
  out +=
      tile(format("%.2f", total.mean), "ms", format("CPU per stereo frame, p99 %.1f", total.p99));
  out += tile(format("%zu", r.frames_tracked), format("/ %zu", r.frames_in).c_str(),
              format("frames tracked, %zu lost", r.frames_lost));
  out += tile(format("%.1f", double(r.pool_bytes) / (1024 * 1024)), "MB", "static memory, no heap");
  return out + "</div>\n";
}

}  // namespace

std::string make_report(const RunInfo& info, const Recording& recording, const RunLog& log,
                        const RunResult& result, const std::vector<Count>& player_rejected,
                        const std::string& viewer) {
  Source source{recording, log, result, recording.frames.front().t, recording.duration_s(), {}};
  source.health = health_spans(source);
  std::vector<Count> input = recording.rejected;
  input.insert(input.end(), player_rejected.begin(), player_rejected.end());
  const std::string body = head(info, result) + viewer_section(source, viewer) +
                           trajectory_section(source) + gnss_section(source) +
                           error_section(source) + timing_section(source) + state_section(source) +
                           health_section(source) + heading("Counters") +
                           counter_list(log.counters) + heading("Input rejected by the reader") +
                           counter_list(input) + memory_section(source);
  return html_page("PIRVS: " + info.sequence, body);
}

}  // namespace pirvs::tools
