// The filter with a short memory: what came is applied at its own time, and what came after it
// once more.
// In      entries: a fix, SLAM's pose at a frame, a frame without one; late by kHistory entries at
//         most.
// Out     newest(): the state after the newest entry. The same entries give the same state,
//         whatever the order in which they came. Events are counted, and `resets` with those by
//         which the pose may jump.
// Frames  E, W, B as in fusion_state.h.
// Units   m, rad, ns.
// Errors  insert: kStale, it is older than all that is kept; nothing changes.
// Cost    ~10 us an entry that is applied, x86-64; 60 kB.
// Source  PIRVS paper, eq. 7 to 9; docs/adr/0017-fusion-anchors-slam.md.
#pragma once

#include "core/base/counter.h"
#include "core/base/status.h"
#include "modules/fusion/fix_check.h"
#include "modules/fusion/fusion_state.h"

namespace pirvs {

enum class FusionEvent : uint8_t {
  kAligned,        // SLAM's frame was found on the Earth
  kAnchoredAnew,   // SLAM had jumped: the anchor went along
  kSlamJumped,     // ... and had not said so
  kHeadingLost,    // SLAM was away for too long
  kFoundBack,      // SLAM is back in the world that it was anchored in
  kFixesBelieved,  // fixes were rejected for long, but agreed: aligned by them
  kGnssRestarted,  // without SLAM: began anew at a fix
  kCount
};
const char* name(FusionEvent event);

struct FusionEntry {
  enum class Kind : uint8_t { kFix, kSlam, kNoSlam, kTime };

  TimeNs t = 0;
  Kind kind = Kind::kTime;
  FixMeasurement fix;
  SlamMeasurement slam;
  // By which SLAM's frame may have drifted since the frame before.
  double drift_horizontal_m2 = 0, drift_vertical_m2 = 0, drift_yaw_rad2 = 0;
  bool jumped = false;  // SLAM says so, and the drift above how far
  FusionState after;
};

class FusionHistory {
 public:
  void configure(const Vec3& p_BA) { p_BA_ = p_BA; }
  void retune(const FusionParams& params) { params_ = params; }
  void clear() { size_ = 0; }

  // The verdict on a fix, and its nis in `entry`; kAccepted for all else.
  Status insert(FusionEntry& entry, FixGate& verdict);
  // All that was is forgotten but `start`, whose state stands.
  void restart(const FusionEntry& start);
  // The newest state is at this fix, whatever was before.
  void place_newest(const FixMeasurement& fix);

  bool empty() const { return size_ == 0; }
  const FusionState& newest() const { return at(size_ - 1).after; }
  // SLAM's last pose; nullptr: SLAM is lost, or no pose is kept.
  const FusionEntry* last_slam() const;
  bool slam_at(TimeNs t, SlamMeasurement& out) const;

  void tell(FusionEvent event, bool again = false);
  const CounterArray<FusionEvent>& events() const { return events_; }
  uint32_t resets() const { return resets_; }

 private:
  static constexpr size_t kHistory = 18    // frames of 300 ms at 60 Hz
                                     + 6;  // fixes of that time, at 20 Hz

  FusionEntry& at(size_t i) { return entries_[(first_ + i) % kHistory]; }
  const FusionEntry& at(size_t i) const { return entries_[(first_ + i) % kHistory]; }
  void place(FusionState& state, const FixMeasurement& fix) const;
  FixGate apply(FusionEntry& entry, FusionState& state, bool again);
  FixGate apply_fix(FusionState& state, FixMeasurement& fix) const;
  void apply_slam(FusionState& state, const FusionEntry& entry, bool again);
  void come_back(FusionState& state, const SlamMeasurement& slam, bool again);

  Vec3 p_BA_ = Vec3::Zero();
  FusionParams params_;
  FusionEntry entries_[kHistory];  // a ring, in order of time
  size_t first_ = 0, size_ = 0;
  CounterArray<FusionEvent> events_;
  uint32_t resets_ = 0;
};

}  // namespace pirvs
