// Watches the two sensors' clocks: where the cameras' stamps lie on the IMU's clock, and whether
// one clock was set against the other.
// In      Each frame's stamp and each IMU sample as the door sees them; the steps of the IMU's
//         stamps that the IMU guard finds; each frame's tracks, which decide a doubt.
// Out     to_imu_clock(): the calibration's offset, and every step since. in_doubt(): stamps of one
//         sensor stepped by more than its period, so that either items were lost or its clock was
//         set; until that is known, nothing may get into the map. judge(): what the tracks say.
// Frames  B, C. Units: ns, rad/s.
// Errors  Doubts that are confirmed are counted: camera_clock_set, imu_clock_set, camera_gap.
// Cost    ~20 us a frame while in doubt, else next to nothing (x86-64). Calls belong to whoever has
//         the frame in work: the door's core, then tracking's, never both.
// Source  clock_check.h; docs/faults.md, "One clock set against the other".
#pragma once

#include "modules/calibration/calibration.h"
#include "modules/door/clock_check.h"
#include "modules/door/door_loss.h"
#include "modules/door/door_params.h"

namespace pirvs {

enum class ClockVerdict : uint8_t { kRight, kCamerasSet, kImuSet };

class ClockWatch {
 public:
  // Once, of a fresh object.
  void configure(const Calibration& calibration, const DoorParams& params);

  TimeNs to_imu_clock(TimeNs camera_stamp) const { return camera_stamp + offset_; }

  // The calibration's offset turns out to be larger by so much.
  void correct(TimeNs later) { offset_ += later; }

  // A frame has come, under the cameras' own stamp.
  void frame_came(TimeNs camera_stamp, DoorLosses& losses);
  // An IMU sample whose stamp stepped by so much more than the samples' period.
  void imu_stepped(TimeNs step) { suspect(step, true); }
  // Time does not go on from the sample before.
  void restart();

  // A frame stamped t is too late for the IMU, which is at imu_t: by so much that the IMU's next
  // samples must say first whether its stamps have gone back, too.
  bool must_wait_for_imu(TimeNs t, TimeNs imu_t);
  // A frame stamped t, though the newest IMU sample, imu_t, is now. kClockSet: several in a row fit
  // a step of the cameras' clock, so it was set.
  enum class Ahead : uint8_t { kPossible, kImpossible, kClockSet };
  Ahead frame_ahead(TimeNs t, TimeNs imu_t);

  void handed_out(const ImuSample& sample) { check_.add_imu(sample); }
  void frame_handed_out(TimeNs t);

  bool has_doubt() const { return shift_ != 0; }
  TimeNs shift() const { return shift_; }  // if a clock was set: frames stamped t belong to t + it
  bool is_imus() const { return is_imus_; }
  // Whether what is sensed at t is not to be trusted with the map.
  bool in_doubt(TimeNs t) const;
  // After the tracks were followed to the frame. kRight: no clock was set, as far as is known; else
  // accept_step() is next.
  ClockVerdict judge(const ClockCheck::Frame& frame);
  void accept_step(DoorLosses& losses);
  void reject_step();

 private:
  void suspect(TimeNs shift, bool is_imus);

  ClockCheck check_;
  TimeNs break_ = 0, clock_step_ = 0;  // of DoorParams
  TimeNs offset_ = 0;                  // of the cameras' stamps to the IMU's clock
  TimeNs shift_ = 0;                   // in doubt; 0: there is none
  TimeNs doubt_since_ = 0;             // the first frame in doubt; 0: none was handed out yet
  bool is_imus_ = false;
  TimeNs raw_frame_t_ = INT64_MIN, frame_period_ = 0;
  TimeNs far_back_since_ = 0;  // IMU time when frames began to come from far back; 0: they do not
  int future_frames_ = 0;      // in a row
};

}  // namespace pirvs
