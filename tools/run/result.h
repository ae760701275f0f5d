// What    A run boiled down: what the summary, the report and the last lines on the screen say.
// In      Recording, RunLog.
// Out     Frame counts, timing statistics of each column, ATE, RPE and NEES, the verdict.
// Units   ms of CPU time per stereo frame; m, deg.
// Errors  none; without ground truth, evaluation.ok is false.
// Source  DESIGN.md, "The front door" (summary.json).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tools/eval/eval.h"
#include "tools/eval/nees.h"
#include "tools/run/fused.h"
#include "tools/run/run_log.h"

namespace pirvs::tools {

struct Statistics {
  double mean = 0, median = 0, p95 = 0, p99 = 0, max = 0;
};

Statistics statistics(std::vector<double> values);

// From one published pose to the next, in ms.
std::vector<double> pose_spacing_ms(const RunLog& log);

struct TimingColumn {
  const char* name;   // as in timing.csv
  const char* label;  // as in the paper's Table II
  float FrameReport::*field;
};
inline constexpr std::array<TimingColumn, 5> kTimingColumns = {{
    {"image_ms", "Image processing", &FrameReport::image_ms},
    {"matching_ms", "Matching", &FrameReport::matching_ms},
    {"tracking_ms", "Tracking", &FrameReport::tracking_ms},
    {"mapping_ms", "Mapping", &FrameReport::mapping_ms},
    {"end_to_end_ms", "End-to-end", &FrameReport::end_to_end_ms},
}};

// The pose jumped at the frame at t, or since the frame before.
struct PoseJump {
  TimeNs t = 0;
  float jump_m = 0, jump_rad = 0;  // of the last, should there have been several
};

struct RunResult {
  size_t frames_in = 0;            // of the recording, or of the part asked for
  size_t frames_tracked = 0;       // with a pose and not lost
  size_t frames_lost = 0;          // after the first pose: no pose, or lost
  size_t frames_before_start = 0;  // processed before the first pose
  size_t frames_dropped = 0;       // never reached the estimator's end
  double duration_s = 0;
  double wall_s = 0;
  std::array<Statistics, kTimingColumns.size()> timing;
  LatencySummary pose_spacing;  // from one published pose to the next
  size_t pool_bytes = 0;
  Trajectory trajectory;  // what trajectory.tum holds
  Evaluation evaluation;
  Nees nees;                     // if the truth has velocities
  std::vector<FusedPose> fused;  // in order of time; empty: no GNSS
  FusedResult fused_result;
  HealthState health_at_end = HealthState::kInitializing;
  size_t frames_degraded = 0;
  Statistics confidence;  // of frames with a pose
  double confidence_min = 0;
  uint32_t resets = 0;
  double localised_after_s = -1;  // in the map that was loaded, since the first frame; < 0: never
  std::vector<PoseJump> jumps;
  std::string verdict;  // why it is not done, if it is not; verdict.h
  bool done = false;    // tracking to the last frame

  int exit_status() const;
};

RunResult make_result(const Recording& recording, const RunLog& log, Status status);

}  // namespace pirvs::tools
