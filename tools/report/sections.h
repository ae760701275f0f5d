// What    What the sections of the report share, and those that have a file of their own.
// In      Source: the run.
// Out     A section's HTML; Figures over the run's time.
// Units   as labelled; times in seconds since the recording's first frame.
// Errors  none.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "tools/report/figure.h"
#include "tools/run/result.h"

namespace pirvs::tools {

inline constexpr int kHalfWidth = 560;

// All that the sections draw from.
struct Source {
  const Recording& recording;
  const RunLog& log;
  const RunResult& result;
  TimeNs t0;
  double end_s;
  std::vector<Span> health;

  double time(TimeNs t) const { return to_seconds(t - t0); }
  Mat3 R_WE() const { return result.evaluation.R_WE; }  // identity without ground truth
  Vec3 aligned(const Vec3& p_E) const { return R_WE() * p_E + result.evaluation.p_WE; }
  bool has_truth() const { return result.evaluation.ok; }
};

template <class... Args>
std::string format(const char* how, Args... args) {
  char text[512];
  std::snprintf(text, sizeof text, how, args...);
  return text;
}

inline std::string card(const std::string& content) {
  return "<div class=card>" + content + "</div>\n";
}

inline std::string heading(const char* text) { return std::string("<h2>") + text + "</h2>\n"; }

inline Figure time_figure(const Source& s, const std::string& title, const std::string& y_label) {
  Figure figure;
  figure.title = title;
  figure.x_label = "time [s]";
  figure.y_label = y_label;
  figure.x_min = 0;
  figure.x_max = s.end_s;
  figure.spans = s.health;
  return figure;
}

// CPU time, latency, matching.
std::string timing_section(const Source& s);

// With GNSS: the map of east and north, what became of the fixes. Empty without.
std::string gnss_section(const Source& s);

}  // namespace pirvs::tools
