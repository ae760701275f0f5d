// Front-ends, tracking and mapping as one: ordered samples and frames in, poses out. Knows no
// sensor, no schedule and no clock but that of CPU time for its reports.
// In      imu(), wheel() and begin() in order of sensor time, a frame only while idle(); then its
//         steps, each on a core of its own if the plan likes.
// Out     fused() after every frame; a FrameReport once a frame is done and the next one begins.
// Frames  W: world, z up, origin at the first keyframe. B: IMU.
// Errors  none to the caller: what is rejected is counted by name.
// Cost    memory: see pools(); time: see FrameReport.
// Source  docs/architecture.md; PIRVS paper, section IV.
#pragma once

#include <atomic>

#include "core/base/text.h"
#include "core/sched/scheduler.h"
#include "modules/app/app_params.h"
#include "modules/app/app_sinks.h"
#include "modules/app/map_gate.h"
#include "modules/calibration/calibration.h"
#include "modules/door/door.h"
#include "modules/frontend/frontend.h"
#include "modules/map/messages.h"
#include "modules/map/nodes.h"
#include "modules/mapping/mapper.h"
#include "modules/tracking/tracker.h"

namespace pirvs {

// Many methods: what its cores, commands and reports need, a line or a few each.
class Estimator {
 public:
  void configure(const Calibration& calibration, const AppParams& params, const AppSinks& sinks);

  // ---- on the door's core, which is tracking's ----
  void imu(const ImuSample& sample, bool stamps_in_doubt);
  void wheel(const WheelSample& sample) { tracker_.add_wheel(sample); }
  // Time does not go on from the item before: nothing can be carried over but the map's frame.
  void interrupt(TimeNs t, const char* why);
  void tell_health(TimeNs t, const char* what);
  // No frame is in work: the next item may come.
  bool idle() const { return stage_.load(std::memory_order_acquire) == Stage::kIdle; }
  void begin(const DoorFrame& frame);
  // Lets the frame go on to the front-ends once the map is there that it shall see.
  Step wait_for_map();
  const DoorFrame& frame() const { return frame_; }  // the one in work
  Step tracking_step();
  void flush_report();
  // ---- on the door's core, while idle() and mapping_rests() ----
  // Forgets map and state; all counters go on.
  void reset(TimeNs t, const char* why);
  // Other parameters from now on; what is tracked goes on.
  void retune(const AppParams& params);
  // W moves so that the body, or the place where a start would continue, is at p_WB with this
  // heading of its x axis. sigma_m > 0, with a loaded map that was not recognised yet: a hint,
  // W stays and what runs begins anew there. kStale: that axis is vertical, there is no heading; or
  // a hint where the place is known.
  Status set_pose(TimeNs t, const Vec3& p_WB, double yaw_rad, double sigma_m = 0);
  // In place of all that is known; a start looks for its place there. Errors as load_map(): the map
  // is empty then.
  Status load_map(TimeNs t, const MapSource& source);
  // Named places (modules/map/nodes.h), in the epoch of the pose now. kStale: there is none.
  Status set_node(const char* name, const SE3& T_WN);
  Result<SE3> node_pose(const char* name) const { return pirvs::node_pose(map(), name); }
  Status remove_node(const char* name) { return pirvs::remove_node(mapper_.map(), name); }

  // See Tracker. After a frame.
  TimeNs correct_time() { return tracker_.correct_time(); }

  const char* calibration_news(int i) const { return calibration_news_[i].c_str(); }

  FusedState fused() const;
  const Tracker& tracker() const { return tracker_; }
  const Tracks& tracks(int camera) const { return frontend_[camera].tracks(); }
  MapGate& map_gate() { return map_gate_; }
  // Mapping has done all that tracking has sent and the gate lets through; and has no other work.
  bool mapping_done() const;
  bool mapping_rests() const { return mapping_done() && !mapper_.busy(); }

  // ---- on the core that the plan says ----
  Step frontend_step(int camera);
  Step mapping_step();

  const Map& map() const { return mapper_.map(); }  // at rest
  int counters(NamedValue* out, int max) const;
  static int pools(NamedValue* out, int max);

 private:
  // Of the frame in work.
  enum class Stage : uint8_t { kIdle, kMap, kFrontend, kTracking };

  // As long as it lives, mapping's step does nothing: a resting mapper is asked for work all the
  // time by its own core.
  class MappingHold {
   public:
    explicit MappingHold(Estimator& estimator) : estimator_(estimator) {
      estimator.mapping_held_.store(true);
      while (estimator.mapping_inside_.load()) {
      }
    }
    ~MappingHold() { estimator_.mapping_held_.store(false); }
    MappingHold(const MappingHold&) = delete;
    MappingHold& operator=(const MappingHold&) = delete;

   private:
    Estimator& estimator_;
  };

  void configure_tracking();
  void rebuild(TimeNs t, const char* why);
  Step adjust_map();
  void tell_calibration();
  void report(const FrameResult& result, TimeNs matching_ns);

  Calibration calibration_;
  AppParams params_;
  AppSinks sinks_;
  Frontend frontend_[kCamerasMax];
  Tracker tracker_;
  Mapper mapper_;
  KeyframeRing keyframe_ring_;
  MapMailbox map_mailbox_;
  MapGate map_gate_;
  uint32_t resets_before_ = 0;  // counted by trackers before the last reset()

  DoorFrame frame_;
  Vec3 gravity_B_ = Vec3::Zero();
  std::atomic<Stage> stage_{Stage::kIdle};
  std::atomic<uint8_t> frontends_left_{0};
  std::atomic<bool> frontend_todo_[kCamerasMax] = {};
  std::atomic<int64_t> frontend_ns_[kCamerasMax] = {};
  std::atomic<int64_t> mapping_ns_{0};
  std::atomic<bool> mapping_held_{false}, mapping_inside_{false};
  int64_t tracking_ns_ = 0;
  FrameReport report_;
  bool report_pending_ = false;
  Text<160> calibration_news_[4];  // of time, turn, wheels, pair: told once, a sink may keep them
};

}  // namespace pirvs
