// Fuses SLAM's poses with fixes of a GNSS receiver, loosely: a pose on the Earth, with its
// covariance, where it comes from and how far it can be trusted. A pure state machine.
// In      add_pose(): SLAM's pose at each frame, health lost where there is none; add_fix(): fixes
//         as they come. Each in order of its own time; a fix may be as late as the history
//         (fusion_history.h) is long.
// Out     pose(): at the newest frame or fix, once there was a good fix. SLAM's own pose stays as
//         it is.
// Frames  E: east, north, up, about the first good fix. W: SLAM's world. B: IMU.
// Units   m, rad, m/s; ns on the IMU's clock.
// Errors  A fix that is not used is counted by name (FixGate), as is each time the anchor is given
//         up or found anew (FusionEvent).
// Cost    add_pose, add_fix ~15 us each, x86-64; a late fix once more for each frame since its
//         time. 0.3 MB.
// Source  PIRVS paper, section IV.D; docs/adr/0017-fusion-anchors-slam.md.
#pragma once

#include "modules/calibration/calibration.h"
#include "modules/fusion/alignment.h"
#include "modules/fusion/fused_pose.h"
#include "modules/fusion/fusion_history.h"
#include "modules/output/pose.h"

namespace pirvs {

class Fusion {
 public:
  void configure(const GnssAntenna& antenna, const FusionParams& params);
  void retune(const FusionParams& params);
  // Time does not go on from before. The place is forgotten, E stays.
  void interrupt();

  // Return true when pose() is new.
  bool add_pose(const Pose& slam);
  bool add_fix(const GnssFix& fix);

  const FusedPose& pose() const { return pose_; }
  const LocalFrame& frame() const { return frame_; }  // E
  bool has_origin() const { return has_origin_; }
  FixGate last_gate() const { return last_gate_; }  // what became of the newest fix
  const CounterArray<FixGate>& gates() const { return gates_; }
  const CounterArray<FusionEvent>& events() const { return history_.events(); }

 private:
  // The largest variance so far; what is above it is new drift. Much less of it is a correction.
  struct Growth {
    double top = 0;
    double add(double variance, bool begin);
  };

  FixGate gate(const GnssFix& fix);
  void watch(const FusionEntry& entry, FixGate gate);
  FusionEntry entry_of(const Pose& pose);
  void add_pair(const FusionEntry& entry);
  void try_to_align();
  void align(const Alignment& found, const FusionEntry& slam, TimeNs now);
  void place_by_window(const FusionEntry& slam);
  void publish();

  GnssAntenna antenna_;
  FusionParams params_;
  LocalFrame frame_;
  bool has_origin_ = false;

  FixCheck check_;
  FusionHistory history_;
  AlignmentWindow window_;  // not anchored: all good fixes; anchored: those rejected in a row
  int accepted_in_a_row_ = 0;
  TimeNs rejected_since_ = INT64_MAX;
  TimeNs accepted_t_ = INT64_MIN;

  Growth growth_horizontal_, growth_vertical_, growth_yaw_;
  TimeNs slam_t_ = INT64_MIN;
  uint32_t slam_resets_ = 0;
  bool slam_runs_ = false;

  FusedPose pose_;
  uint32_t interruptions_ = 0;
  FixGate last_gate_ = FixGate::kNoFix;
  CounterArray<FixGate> gates_;
};

}  // namespace pirvs
