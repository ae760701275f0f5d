#include "tools/run/result.h"

#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "tools/cli/command.h"
#include "tools/run/verdict.h"

namespace pirvs::tools {
namespace {

constexpr double kDelta_s = 1.0;
constexpr double kEndMargin_s = 1.0;  // the last frames may lack IMU samples

// Nearest rank: a value that did occur.
double percentile(const std::vector<double>& sorted, double p) {
  const size_t rank = size_t(std::ceil(p * double(sorted.size())));
  return sorted[std::clamp<size_t>(rank, 1, sorted.size()) - 1];
}

bool lost(const FrameReport& frame) {
  return !frame.has_pose || frame.pose.health == HealthState::kLost;
}

TrajectoryPose trajectory_pose(TimeNs t, const BodyState& state) {
  TrajectoryPose pose;
  pose.t = t;
  pose.t_s = double(t) / 1e9;
  pose.p_WB = state.T_WB.p;
  pose.q_WB = quat_xyzw(state.T_WB.R);
  pose.v_WB = state.v_WB;
  pose.b_g = state.b_g;
  pose.b_a = state.b_a;
  return pose;
}

void count_frames(const RunLog& log, RunResult& result) {
  bool started = false;
  for (const FrameReport& frame : log.frames) {
    started = started || frame.has_pose;
    if (!started) {
      ++result.frames_before_start;
    } else if (lost(frame)) {
      ++result.frames_lost;
    } else {
      ++result.frames_tracked;
    }
  }
  result.frames_dropped = result.frames_in - std::min(result.frames_in, log.frames.size());
}

void count_trust(const RunLog& log, RunResult& result) {
  std::vector<double> confidence;
  for (const FrameReport& frame : log.frames) {
    const Trust& trust = frame.pose.trust;
    if (trust.resets != result.resets) {
      result.jumps.push_back({frame.t, trust.jump_m, trust.jump_rad});
    }
    result.resets = trust.resets;
    if (frame.pose.health == HealthState::kDegraded) ++result.frames_degraded;
    if (frame.has_pose) confidence.push_back(double(trust.confidence));
    if (frame.pose.in_map && result.localised_after_s < 0) {
      result.localised_after_s = to_seconds(frame.t - log.frames.front().t);
    }
  }
  result.confidence = statistics(confidence);
  if (confidence.empty()) return;
  result.confidence_min = *std::min_element(confidence.begin(), confidence.end());
}

LatencySummary summary_of(std::vector<double> ms) {
  LatencySummary out;
  if (ms.empty()) return out;
  std::sort(ms.begin(), ms.end());
  out = {ms.size(), ms.front(), percentile(ms, 0.5), percentile(ms, 0.99), ms.back()};
  return out;
}

size_t counter(const RunLog& log, DoorLoss loss) {
  for (const Count& count : log.counters) {
    if (count.name == name(loss)) return count.value;
  }
  return 0;
}

// Poses until the recording's end. Where the IMU's clock was set, stamps cannot tell; the frames
// that came after its end can.
bool is_whole(const Recording& recording, const RunLog& log) {
  const TimeNs end = recording.frames.back().t + recording.calibration.camera_time_offset_ns;
  if (log.frames.back().t >= end - from_seconds(kEndMargin_s)) return true;
  const double late = double(counter(log, DoorLoss::kFrameWithoutImu));
  const bool set = counter(log, DoorLoss::kImuClockBack) + counter(log, DoorLoss::kImuClockSet) > 0;
  return set && late * recording.duration_s() <= kEndMargin_s * double(recording.frames.size());
}

}  // namespace

Statistics statistics(std::vector<double> values) {
  Statistics out;
  if (values.empty()) return out;
  std::sort(values.begin(), values.end());
  for (const double v : values) out.mean += v;
  out.mean /= double(values.size());
  out.median = percentile(values, 0.5);
  out.p95 = percentile(values, 0.95);
  out.p99 = percentile(values, 0.99);
  out.max = values.back();
  return out;
}

std::vector<double> pose_spacing_ms(const RunLog& log) {
  std::vector<double> out;
  for (size_t i = 1; i < log.poses.size(); ++i) {
    out.push_back(1e3 * to_seconds(log.poses[i].t_published - log.poses[i - 1].t_published));
  }
  return out;
}

int RunResult::exit_status() const { return done ? kExitDone : kExitFailed; }

RunResult make_result(const Recording& recording, const RunLog& log, Status status) {
  RunResult result;
  result.frames_in = recording.frames.size();
  result.duration_s = recording.duration_s();
  count_frames(log, result);
  count_trust(log, result);
  for (size_t i = 0; i < kTimingColumns.size(); ++i) {
    std::vector<double> values;
    for (const FrameReport& f : log.frames) values.push_back(double(f.*kTimingColumns[i].field));
    result.timing[i] = statistics(values);
  }
  result.pose_spacing = summary_of(pose_spacing_ms(log));
  for (const Count& pool : log.pools) result.pool_bytes += pool.value;
  std::vector<StateEstimate> estimates;
  for (const FrameReport& frame : log.frames) {
    if (!frame.has_pose) continue;
    const TrajectoryPose pose = trajectory_pose(frame.t, frame.pose.state);
    result.trajectory.poses.push_back(pose);
    estimates.push_back({pose, frame.pose.cov});
  }
  if (!result.trajectory.poses.empty() && recording.truth.poses.size() > 1) {
    result.evaluation = evaluate(result.trajectory, recording.truth, kDelta_s);
    if (!log.keyframes.empty()) {
      const BodyState& first = log.keyframes.front();
      result.nees = evaluate_nees(estimates, trajectory_pose(first.t, first), recording.truth);
    }
  }
  result.fused = in_order(log.fused);
  result.fused_result = evaluate_fused(recording, result.fused, log.local_frame);
  if (!log.frames.empty()) result.health_at_end = log.frames.back().pose.health;
  if (log.frames.empty()) return result;
  result.verdict = verdict(recording, log);
  result.done = status == Status::kOk && is_whole(recording, log) && result.verdict.empty();
  return result;
}

}  // namespace pirvs::tools
