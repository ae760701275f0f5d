// Was one sensor's clock set against the other's? Stamps alone cannot tell that from items that
// were lost on the way; how the image turns, against how the gyro says the body turns, can.
// In      The IMU's samples; each frame's tracks after they were followed to it; the shift in
//         doubt: if the clock was set, a frame stamped t was taken when the IMU's clock showed t +
//         shift.
// Out     kHold: the stamps are right. kSet: the clock was set. kOpen: not known yet; a body that
//         does not turn says nothing.
// Frames  B, C. Units: ns, rad/s.
// Errors  none. A shift beyond what the history of samples covers (about 7 s) stays open.
// Cost    ~20 us a frame while there is doubt, else nothing but keeping the samples (x86-64).
// Source  docs/conventions.md, "A start from one camera", step 1: once the turn is taken out, the
//         planes of all tracks meet in the direction of travel; here for two turns to choose from.
#pragma once

#include "core/camera/camera.h"
#include "core/store/fixed_vector.h"
#include "modules/frontend/frontend.h"
#include "modules/imu/imu_sample.h"

namespace pirvs {

class ClockCheck {
 public:
  enum class Verdict : uint8_t { kOpen, kHold, kSet };
  struct Frame {
    TimeNs t;
    int camera;  // the tracks'
    const Tracks* tracks;
    Vec3 b_g;  // the gyro's bias; what was known before the doubt counts
  };

  void configure(const Camera* cameras);
  void reset();  // time does not go on from the last sample
  void add_imu(const ImuSample& sample);
  // Every frame in order; shift 0: no doubt.
  Verdict frame(const Frame& frame, TimeNs shift);

 private:
  static constexpr size_t kPairs = 40;      // tracks of a frame that are looked at
  static constexpr size_t kFrames = 128;    // that wait for the gyro's samples
  static constexpr size_t kHistory = 2048;  // samples
  struct Pair {
    Eigen::Vector3f before_C, now_C;  // bearings of one track
  };
  struct Motion {  // from the frame before to this one
    TimeNs begin, end;
    int camera;
    FixedVector<Pair, kPairs> pairs;
  };

  void see(const Frame& frame, TimeNs before);
  bool felt_turn(TimeNs begin, TimeNs end, Mat3& R_B1B0) const;
  double misfit(const Motion& motion, const Mat3& R_B1B0) const;
  void compare();
  Verdict judge() const;

  Camera camera_[kCamerasMax];
  ImuSample history_[kHistory];
  size_t history_size_ = 0;  // samples ever kept; the newest is at (size - 1) % kHistory
  TimeNs shift_ = 0;
  Vec3 b_g_ = Vec3::Zero();
  TimeNs last_t_ = 0;
  int last_camera_ = -1;
  FixedVector<Motion, kFrames> motions_;
  int compared_ = 0;  // motions, and by how much the shifted turns fit better, 0 to 1 each
  double time_s_ = 0, better_ = 0, better2_ = 0;
};

}  // namespace pirvs
