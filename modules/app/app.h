// The whole stack as one static object: sensors in by the bsp's contracts, poses out by sinks.
// In      bsp::camera_poll, bsp::imu_poll; a Calibration; parameters.
// Out     AppSinks: every pose at IMU rate, a report per frame, health changes; the map at the end.
// Frames  W: world, z up, origin at the first keyframe. B: IMU. Time: the IMU's clock, ns.
// Errors  kBadData from run(): the sensors ended before a start. Rejected samples are counted.
// Cost    memory: see pools(); time: see FrameReport.
// Source  docs/architecture.md.
#pragma once

#include <atomic>

#include "bsp/api/camera.h"
#include "core/base/status.h"
#include "core/sched/scheduler.h"
#include "modules/app/app_params.h"
#include "modules/calibration/calibration.h"
#include "modules/door/clock_check.h"
#include "modules/door/door.h"
#include "modules/frontend/frontend.h"
#include "modules/mapping/mapper.h"
#include "modules/recorder/recorder.h"
#include "modules/tracking/tracker.h"

namespace pirvs {

struct PoseOutput {
  BodyState state;
  Mat15 cov = Mat15::Zero();
  HealthState health;
  Trust trust;
};

struct FrameReport {
  TimeNs t = 0;
  bool has_pose = false;
  PoseOutput pose;
  float image_ms = 0, matching_ms = 0, tracking_ms = 0, mapping_ms = 0, end_to_end_ms = 0;
  int tracks[kCamerasMax] = {0, 0};
  int correspondences = 0, accepted = 0;
  bool keyframe = false;
  bool at_rest = false;
};

struct AppSinks {
  void* context = nullptr;
  void (*pose)(void*, const PoseOutput&) = nullptr;  // at IMU rate
  void (*frame)(void*, const FrameReport&) = nullptr;
  void (*health)(void*, TimeNs, HealthState, const char* what) = nullptr;
  void (*keyframe)(void*, const BodyState&) = nullptr;  // leaving the map, refined as it is then
};

// The farthest that a replay as fast as possible runs ahead of mapping: what a device whose mapping
// needs two frames for a keyframe would see.
inline constexpr TimeNs kMappingLag_ns = 100'000'000;

struct NamedValue {
  const char* name;
  uint64_t value;
};

// Which core runs what. On one core all tasks interleave.
struct CorePlan {
  uint8_t cores = 1;
  uint8_t door = 0, left = 0, right = 0, tracking = 0, mapping = 0;
};

// How fast the recording may come. Live sensors and real-time replay never wait for us. kLockstep:
// the next sample comes when nothing is left to do on any core, so that any plan gives the bytes
// that one core gives.
enum class Pace : uint8_t { kSensors, kAsWeGo, kLockstep };

class App {
 public:
  // Forgets everything from an earlier run.
  void configure(const Calibration& calibration, const AppParams& params, const AppSinks& sinks);
  // Between configure() and run(): whatever comes to the door is also written by bsp/api/storage.h
  // as an ASL folder, from a core of its own, the first that the plan leaves free. kBusFault,
  // kFull, kNotFound: the storage refuses.
  Status record();
  // Runs until the sensors end. kAsWeGo on one core is lockstep; on several, mapping may lag by at
  // most kMappingLag_ns of sensor time.
  Status run(const CorePlan& plan, Pace pace);

  const Map& map() const { return mapper_.map(); }
  // Every counter of rejections and faults, from any core, also while run() runs; sizes of the static
  // pools in bytes. Return how many there are.
  int counters(NamedValue* out, int max) const;
  static int pools(NamedValue* out, int max);

 private:
  enum class Stage : uint8_t { kFree, kFrontend, kTracking };
  enum TaskIndex : int { kDoor, kLeft, kRight, kTracking, kMapping, kTasks };

  Step door_step();
  Step frontend_step(int camera);
  Step tracking_step();
  Step mapping_step();
  bool world_waits(TimeNs t) const;
  void interrupt(TimeNs t, const char* why);
  bool stamps_in_doubt(TimeNs t) const;
  void check_clocks();
  Status start_recorder();
  void note_task_counters();
  void begin_frame(const DoorFrame& frame);
  void deliver(const ImuSample& sample);
  void flush_report();

  Calibration calibration_;
  AppParams params_;
  AppSinks sinks_;
  Door door_;
  ClockCheck clock_check_;
  Frontend frontend_[kCamerasMax];
  Tracker tracker_;
  Mapper mapper_;
  Recorder recorder_;
  KeyframeRing keyframe_ring_;
  MapMailbox map_mailbox_;

  DoorFrame frame_;
  Vec3 gravity_B_ = Vec3::Zero();
  std::atomic<Stage> stage_{Stage::kFree};
  std::atomic<uint8_t> frontends_left_{0};
  std::atomic<bool> frontend_todo_[kCamerasMax] = {};
  std::atomic<int64_t> frontend_ns_[kCamerasMax] = {};
  std::atomic<int64_t> mapping_ns_{0};
  int64_t tracking_ns_ = 0;
  FrameReport report_;
  bool report_pending_ = false;
  Scheduler* scheduler_ = nullptr;  // while running
  Pace pace_ = Pace::kAsWeGo;
  CorePlan plan_;
  TaskCounters task_counters_[kTasks];
  TimeNs door_t_ = 0;             // of the last item handed out
  TimeNs mapping_pending_t_ = 0;  // when mapping last had nothing to do, sensor time
};

}  // namespace pirvs
