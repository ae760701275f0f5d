#include "tests/replay.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>

#include "board/host/board.h"
#include "bsp/linux/storage.h"
#include "core/base/assert.h"
#include "tools/map/map_files.h"
#include "tools/run/feed.h"

namespace pirvs::systems {
namespace {

App app;

}  // namespace

size_t Replay::counter(const std::string& name) const {
  for (const auto* counts : {&log.counters, &rejected}) {
    for (const tools::Count& count : *counts) {
      if (count.name == name) return count.value;
    }
  }
  PIRVS_ASSERT(!"a counter of that name");
  return 0;
}

size_t Replay::applied(const std::string& spec) const {
  for (const tools::Count& fault : faults) {
    if (fault.name == spec) return fault.value;
  }
  PIRVS_ASSERT(!"a fault of that run");
  return 0;
}

std::string Replay::trajectory() const {
  std::string out;
  for (const tools::TrajectoryPose& pose : result.trajectory.poses) {
    out += tools::tum_line(pose.t, pose.p_WB, pose.q_WB);
  }
  return out;
}

double Replay::first_pose_s() const {
  if (result.trajectory.poses.empty()) return std::numeric_limits<double>::infinity();
  return to_seconds(result.trajectory.poses.front().t - log.frames.front().t);
}

double Replay::ate_of_path() const {
  return result.evaluation.ate_rmse_m / result.evaluation.path_m;
}

Replay replay(const tools::Recording& recording, const ReplayOptions& options) {
  std::vector<tools::Fault> faults;
  for (const std::string& spec : options.faults) faults.push_back(tools::parse_fault(spec));
  Replay out{Status::kOk, tools::RunLog(recording.frames.size()), {}, {}, {}};
  alarm(kReplay_s_max);
  {
    tools::Feed feed(recording, faults, {}, from_seconds(options.camera_latency_s));
    AppParams params;
    params.tracking.tracker.estimate_time = options.estimate_time ? 1 : 0;
    params.tracking.wheels.estimate_scale = options.estimate_wheels ? 1 : 0;
    params.mapping.extend_map = options.extend_map ? 1 : 0;
    app.configure(recording.calibration, params, out.log.sinks());
    if (!options.load_map.empty()) {
      tools::read_map_file(options.load_map,
                           [](const MapSource& from) { return app.load_map(from); });
    }
    const bool live = options.playback == tools::Playback::kRealTime;
    if (!live) app.replay_inbox(feed.inbox());
    if (!live && options.mapping_lag < 0) app.replay_maps(feed.maps());
    if (!options.record.empty()) {
      bsp::set_storage_directory(options.record.c_str());
      PIRVS_ASSERT(app.record() == Status::kOk);
    }
    std::thread other;
    if (options.while_it_runs) other = std::thread([&] { options.while_it_runs(app); });
    if (options.mapping_lag >= 0) app.delay_mapping(options.mapping_lag);
    out.status = play(app, feed.source(), board::kPlans[options.cores - 1], options.playback);
    if (other.joinable()) other.join();
    bsp::set_storage_directory(".");
    out.rejected = feed.rejected();
    out.faults = feed.faults_applied();
  }
  alarm(0);
  out.log.finish(app);
  if (!options.save_map.empty()) tools::write_map_file(options.save_map, app.map());
  out.result = make_result(recording, out.log, out.status);
  return out;
}

void expect_no_failures(const Replay& replay) {
  for (const char* name : {"adjustments_failed", "keyframes_dropped", "bundle_full", "points_full",
                           "poses_not_finite"}) {
    EXPECT_EQ(replay.counter(name), 0u) << name;
  }
}

void print(const char* what, const Replay& replay) {
  const tools::RunResult& r = replay.result;
  std::printf("%s: %zu of %zu frames tracked, %zu lost, first pose after %.2f s, ", what,
              r.frames_tracked, r.frames_in, r.frames_lost, replay.first_pose_s());
  std::printf("ATE %.4f m, %.2f %% of %.1f m, CPU %.2f ms a frame\n", r.evaluation.ate_rmse_m,
              100 * replay.ate_of_path(), r.evaluation.path_m, r.timing.back().mean);
}

}  // namespace pirvs::systems
