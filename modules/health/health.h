// Says how far the output can be trusted.
// In      per frame: correspondences, accepted and rejected, their spread; what the filter holds;
//         rest or not; jumps of the pose.
// Out     HealthState, confidence 0 to 1, reasons to doubt it, and the resets.
// Units   s, m, rad.
// Errors  none. Cost: negligible.
// Source  docs/health.md; PIRVS paper, section IV.B (tracking with few correspondences).
#pragma once

#include <cstdint>

#include "core/base/time.h"
#include "modules/health/health_params.h"

namespace pirvs {

inline constexpr float kDoubtConfidence = 0.25f;  // the most while stamps are in doubt

enum class HealthState : uint8_t { kInitializing, kTracking, kDegraded, kLost, kCount };
const char* name(HealthState state);

// Why a pose is to be doubted: bit i of Trust::reasons is Reason(i).
enum class Reason : uint8_t {
  kBlind,      // too few correspondences: dead reckoning
  kRejected,   // much of what is seen is not where it should be
  kJumps,      // corrections of its own, again and again
  kAccelBias,  // beyond what an accelerometer has
  kGyroBias,   // beyond what a gyro has
  kSpeed,      // beyond what the device can do
  kStamps,     // one sensor's may be wrong
  kDenied,     // what ran before this start was hopeless, not long ago
  kPlatform,   // the picture stands while the IMU is pushed: what is seen moves along
  kCameras,    // they do not see at the same time, or are turned against each other
  kTurn,       // gyro and image turn against each other

  kCount
};
const char* name(Reason reason);
inline constexpr uint16_t bit(Reason reason) {
  return static_cast<uint16_t>(1u << static_cast<int>(reason));
}

// What a consumer can act on within one frame.
struct Trust {
  float confidence = 0;            // 0: do not use, 1: as good as it gets
  uint32_t resets = 0;             // changes whenever the pose may have jumped
  float jump_m = 0, jump_rad = 0;  // size of the last jump
  uint16_t reasons = 0;            // not to trust it; 0: none
};

struct FrameEvidence {
  TimeNs t = 0;
  int accepted = 0;  // correspondences
  int cells = 0;     // of kCells in the image that hold one or more of them
  double position_sigma_m = 0;
  bool at_rest = false;
  int rejected = 0;  // correspondences
  double speed_m_s = 0, accel_bias_m_s2 = 0, gyro_bias_rad_s = 0;
  bool moved_along = false, cameras_disagree = false;
  bool turns_against = false;  // gyro and image
};

class Health {
 public:
  static constexpr int kCells = 12;  // 4 x 3
  void configure(const HealthParams& params) { params_ = params; }
  void started(TimeNs t);
  // Returns true when the state changed.
  bool update(const FrameEvidence& evidence);
  // The pose went from one place to another without having moved so; small steps are no jumps.
  // `certain`: count it whatever its size.
  bool note_jump(double jump_m, double jump_rad, bool certain);
  // Frames and IMU samples may not belong together: whatever fits, little is to be trusted.
  void doubt_stamps(bool in_doubt) { in_doubt_ = in_doubt; }
  void lost() {
    state_ = HealthState::kLost;
    trust_.confidence = 0;
  }
  // Lost because it was hopeless, not because nothing was seen: where it went is no place to go on
  // from.
  bool denied() const { return denied_; }
  HealthState state() const { return state_; }
  const Trust& trust() const { return trust_; }

 private:
  float judge(const FrameEvidence& evidence) const;
  uint16_t find_reasons(const FrameEvidence& evidence, double dt_s);
  bool hopeless(const FrameEvidence& evidence);

  HealthParams params_;
  HealthState state_ = HealthState::kInitializing;
  Trust trust_;
  TimeNs last_good_ = 0, good_since_ = 0;
  bool good_ = false, in_doubt_ = false;
  double blind_s_ = 0;  // since the last frame with enough correspondences
  TimeNs last_t_ = 0;
  double rejected_share_ = 0, rejected_long_ = 0;  // of late, and over some seconds
  double jumps_ = 0;                               // of its own, of late
  double hopeless_s_ = 0;
  bool denied_ = false;
  TimeNs denied_until_ = 0;
};

}  // namespace pirvs
