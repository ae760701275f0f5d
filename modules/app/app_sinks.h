// What App tells while it runs, and to whom.
// Frames  W: world, z up, origin at the first keyframe. B: IMU. Time: the IMU's clock, ns.
// Errors  none: a sink must not fail. It runs within a timed step: keep it short.
// Source  docs/architecture.md.
#pragma once

#include "bsp/api/imu.h"
#include "core/base/limits.h"
#include "core/base/status.h"
#include "core/sched/late_watch.h"
#include "modules/door/command.h"
#include "modules/fusion/fix_check.h"
#include "modules/fusion/fused_pose.h"
#include "modules/output/pose.h"

namespace pirvs {

struct StereoFrame;
class Tracker;

struct FrameReport {
  TimeNs t = 0;
  bool has_pose = false;
  FusedState pose;
  float image_ms = 0, matching_ms = 0, tracking_ms = 0, mapping_ms = 0, end_to_end_ms = 0;
  int tracks[kCamerasMax] = {0, 0};
  int correspondences = 0, accepted = 0;
  bool keyframe = false;
  bool at_rest = false;
};

// All are called on the door's core, keyframe() on mapping's.
struct AppSinks {
  void* context = nullptr;
  void (*frame)(void*, const FrameReport&) = nullptr;
  // A frame was tracked: for viewers. t: on the IMU's clock. Images and tracker are lent until the
  // sink returns.
  void (*tracked)(void*, TimeNs t, const StereoFrame&, const Tracker&) = nullptr;
  void (*health)(void*, TimeNs, HealthState, const char* what) = nullptr;
  // With GNSS, from its first good fix on: after each frame and fix. A late fix changes the pose
  // at the newest time.
  void (*fused)(void*, const FusedPose&) = nullptr;
  void (*imu)(void*, const ImuSample&) = nullptr;          // each that is fresh, as it was measured
  void (*fix)(void*, const GnssFix&, FixGate) = nullptr;   // what became of it
  void (*keyframe)(void*, const BodyState&) = nullptr;     // leaving the map, refined as it is then
  void (*answer)(void*, const Answer&) = nullptr;          // to a command
  void (*late)(void*, TimeNs, const LateTask&) = nullptr;  // live alone: a task is late repeatedly
  // A recording begins: where, below the storage's own folder, ending with '/'. The text must stay
  // until the next is asked for. Without this sink all go to the storage's own folder.
  Result<const char*> (*new_recording)(void*) = nullptr;
};

struct NamedValue {
  const char* name;
  uint64_t value;
};

}  // namespace pirvs
