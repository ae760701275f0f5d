// Looks for a start with the cameras that see something, and says where it continues.
// In      frames with their tracks while tracking does not run; where tracking was lost.
// Out     a start (starter.h) whose world is that of the track before; how uncertain its place is.
// Errors  kEmpty: more frames needed. kStale: the attempt failed and begins anew.
// Cost    starter.h.
// Source  own.
#pragma once

#include "modules/tracking/associator.h"
#include "modules/tracking/keyframer.h"
#include "modules/tracking/starter.h"

namespace pirvs {

inline constexpr uint8_t kLeftAlone = 1, kRightAlone = 2, kBothSee = 3;  // cameras, a bit each

class Initializer {
 public:
  void configure(const Camera* cameras, int count, const ImuNoise& noise,
                 const FilterParams& filter, const TrackerParams& params,
                 const ImuHistory* history);
  void set_noise(const ImuNoise& noise) { starter_.set_noise(noise); }
  void configure_wheels(const SE3& T_BV, const WheelParams& params, const WheelHistory* wheels) {
    starter_.configure_wheels(T_BV, params, wheels);
  }
  // Time does not go on: the attempt under way is none.
  void interrupt();
  // Tracking was lost there; the next start continues that place.
  void lost(const BodyState& state, const Mat6& error);
  void fail() { starter_.reset(); }  // the start that was found cannot be used

  // The gyro alone, from one sample to the next.
  void turn(const ImuSample& before, const ImuSample& now);
  // How the body has turned since this was asked last.
  Mat3 take_turn();
  // Every frame, while tracking runs as well.
  void note_seen(TimeNs t, uint8_t seen);

  // kOk: starter() holds a start.
  Status add_frame(TimeNs t, uint8_t seen, const StandstillDetector& standstill,
                   Keyframer& keyframer, Associator& associator);
  Starter& starter() { return starter_; }
  const SE3& origin() const { return origin_; }
  void move_origin(const SE3& T) { origin_ = T * origin_; }
  // Of the place where a start at t continues, by how long nothing was tracked; 0: nothing was.
  Mat6 origin_error(TimeNs t) const;

 private:
  uint8_t cameras_for(TimeNs t, uint8_t seen, const Associator& associator) const;

  Starter starter_;
  int cameras_ = kCamerasMax;
  TrackerParams params_;
  uint8_t start_cameras_ = 0;  // that the attempt looks through, a bit each
  TimeNs last_pair_t_ = 0;     // when both cameras last saw something
  TimeNs pairless_t_ = 0;      // since when both see, but nothing that both see; 0: not so
  SE3 origin_;                 // where a start continues
  Mat6 origin_error_ = Mat6::Zero();
  TimeNs origin_t_ = 0;             // 0: there is none yet
  Mat3 R_BlBn_ = Mat3::Identity();  // last frame to now
  Observations observations_[kCamerasMax];
};

}  // namespace pirvs
