// Fuses SLAM's poses with fixes of a GNSS receiver, loosely: a pose on the Earth, with its
// covariance, where it comes from and how far it can be trusted. A pure state machine.
// In      add_pose(): SLAM's pose at each frame, health lost where there is none; add_fix(): fixes as
//         they come. Each in order of its own time; a fix may be late by kHistory frames: what
//         came after its time is undone, and done again with it.
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

#include "core/base/counter.h"
#include "core/math/geodesy.h"
#include "modules/calibration/calibration.h"
#include "modules/door/items.h"
#include "modules/fusion/alignment.h"
#include "modules/fusion/fused_pose.h"
#include "modules/fusion/fusion_params.h"
#include "modules/fusion/fusion_state.h"
#include "modules/output/pose.h"

namespace pirvs {

// What became of a fix.
enum class FixGate : uint8_t {
  kAccepted,
  kNoFix,         // the receiver says that it has none
  kNotFinite,     // or not on the Earth
  kUncertain,     // the receiver says so
  kBackwards,     // not later than the fix before
  kTooLate,       // older than the history
  kFrozen,        // the same numbers as before, while the body has moved
  kPosition,      // chi square
  kVelocity,      // chi square; the position was used
  kCount
};
const char* name(FixGate gate);

enum class FusionEvent : uint8_t {
  kAligned,          // SLAM's frame was found on the Earth
  kAnchoredAnew,     // SLAM had jumped: the anchor went along
  kSlamJumped,       // ... and had not said so
  kHeadingLost,      // SLAM was away for too long
  kFoundBack,        // SLAM is back in the world that it was anchored in
  kFixesBelieved,    // fixes were rejected for long, but agreed: aligned by them
  kGnssRestarted,    // without SLAM: began anew at a fix
  kCount
};
const char* name(FusionEvent event);

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
  FixGate last_gate() const { return last_gate_; }
  const CounterArray<FixGate>& gates() const { return gates_; }
  const CounterArray<FusionEvent>& events() const { return events_; }

 private:
  static constexpr size_t kHistory = 18    // frames of 300 ms at 60 Hz
                                     + 6;  // fixes of that time, at 20 Hz

  struct Fix {
    Vec3 p_E = Vec3::Zero(), v_E = Vec3::Zero();
    Vec3 variance = Vec3::Zero(), velocity_variance = Vec3::Zero();
    bool has_velocity = false;
    double nis = 0;  // of the position, when it was used or rejected
  };
  struct Slam {
    SlamMeasurement pose;
    double drift_horizontal_m2 = 0, drift_vertical_m2 = 0, drift_yaw_rad2 = 0;
    bool jumped = false;
  };
  enum class Kind : uint8_t { kFix, kSlam, kNoSlam, kTime };
  struct Entry {
    TimeNs t = 0;
    Kind kind = Kind::kFix;
    Fix fix;
    Slam slam;
    FusionState after;
  };
  // The largest variance so far; what is above it is new drift.
  struct Growth {
    double top = 0;
    double add(double variance, bool begin);
  };

  Entry& at(size_t i) { return history_[(first_ + i) % kHistory]; }
  const Entry& at(size_t i) const { return history_[(first_ + i) % kHistory]; }
  const FusionState* newest() const { return entries_ == 0 ? nullptr : &at(entries_ - 1).after; }
  FixGate check(const GnssFix& fix, TimeNs t);
  bool is_frozen(const GnssFix& fix, TimeNs t);
  Fix measured(const GnssFix& fix) const;
  void place(FusionState& state, const Fix& fix) const;
  FixGate apply_fix(FusionState& state, Fix& fix) const;
  void apply_slam(FusionState& state, const Slam& slam, bool again);
  void come_back(FusionState& state, const Slam& slam, bool again);
  FixGate apply(Entry& entry, FusionState& state, bool again);
  bool insert(Entry& entry, FixGate& gate);
  const Entry* last_slam() const;
  bool slam_at(TimeNs t, SlamMeasurement& out) const;
  void watch(const Entry& entry, FixGate gate);
  void add_pair(const Entry& entry);
  void try_to_align();
  void align(const Alignment& found, const Entry& slam, TimeNs now);
  Slam slam_of(const Pose& pose);
  void tell(FusionEvent event, bool again);
  void publish();

  GnssAntenna antenna_;
  FusionParams params_;
  LocalFrame frame_;
  bool has_origin_ = false;

  Entry history_[kHistory];  // a ring, in order of time
  size_t first_ = 0, entries_ = 0;

  AlignmentWindow window_;  // not anchored: all good fixes; anchored: those rejected in a row
  int accepted_in_a_row_ = 0;
  double misclaim_ = 1;      // by which the receiver's sigmas are too small, as the last misfit said
  TimeNs rejected_since_ = INT64_MAX;

  Growth growth_horizontal_, growth_vertical_, growth_yaw_;
  TimeNs slam_t_ = INT64_MIN;
  uint32_t slam_resets_ = 0;
  bool slam_runs_ = false;

  GnssFix last_fix_;
  bool has_fix_ = false;
  Vec3 p_W_changed_ = Vec3::Zero();  // where SLAM was when the numbers of the fixes last changed
  TimeNs accepted_t_ = INT64_MIN;
  FixGate last_gate_ = FixGate::kNoFix;

  FusedPose pose_;
  uint32_t resets_ = 0;
  CounterArray<FixGate> gates_;
  CounterArray<FusionEvent> events_;
};

}  // namespace pirvs
