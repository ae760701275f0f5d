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
#include "modules/app/calibration.h"
#include "modules/app/door.h"
#include "modules/frontend/frontend.h"
#include "modules/imu/imu_params.h"
#include "modules/mapping/mapper.h"
#include "modules/tracking/tracker.h"

namespace pirvs {

struct PoseOutput {
  BodyState state;
  Mat15 cov;
  HealthState health;
};

struct FrameReport {
  TimeNs t = 0;
  bool has_pose = false;
  PoseOutput pose;
  float image_ms = 0, matching_ms = 0, tracking_ms = 0, mapping_ms = 0, end_to_end_ms = 0;
  int tracks[kCamerasMax] = {0, 0};
  int correspondences = 0, accepted = 0;
  bool keyframe = false;
};

struct AppSinks {
  void* context = nullptr;
  void (*pose)(void*, const PoseOutput&) = nullptr;  // at IMU rate
  void (*frame)(void*, const FrameReport&) = nullptr;
  void (*health)(void*, TimeNs, HealthState, const char* what) = nullptr;
  void (*keyframe)(void*, const BodyState&) = nullptr;  // leaving the map, refined as it is then
};

struct AppParams {
  ImuParams imu;
  FrontendParams frontend;
  TrackingParams tracking;
  MappingParams mapping;
};

struct NamedValue {
  const char* name;
  uint64_t value;
};

class App {
 public:
  void configure(const Calibration& calibration, const AppParams& params, const AppSinks& sinks);
  // Runs until the sensors end, with every task on the given number of cores (1: lockstep,
  // deterministic).
  Status run(int cores);

  const Map& map() const { return mapper_.map(); }
  // Every counter of rejections and faults; sizes of the static pools in bytes. Return the count.
  int counters(NamedValue* out, int max) const;
  static int pools(NamedValue* out, int max);

 private:
  enum class Stage : uint8_t { kFree, kFrontend, kTracking };

  bool door_step();
  bool frontend_step(int camera);
  bool tracking_step();
  bool mapping_step();
  void begin_frame(const DoorFrame& frame);
  void deliver(const ImuSample& sample);
  void flush_report();

  Calibration calibration_;
  AppParams params_;
  AppSinks sinks_;
  Door door_;
  Frontend frontend_[kCamerasMax];
  Tracker tracker_;
  Mapper mapper_;
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
  bool ended_ = false;
};

}  // namespace pirvs
