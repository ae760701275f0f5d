// The sensor door: one stream, ordered by sensor time, on the IMU's clock, of what the sensors can
// have sensed.
// In      bsp::imu_poll and bsp::camera_poll, each in its own order.
// Out     next(): IMU samples, then a frame once a sample exactly at its time has been handed out
//         (interpolated when the IMU has none there). A frame may lack one image or both. broken:
//         time does not go on from the item before; whoever integrates must start anew.
// Units   ns, rad/s, m/s^2.
// Errors  kEmpty: nothing now. kTimeout, once each time: the IMU has said nothing for bridge_s.
//         kStale: the sensors have ended. Bad input is dropped and counted: docs/faults.md.
//         Cameras that stay silent delay the IMU by frame_wait_s at most.
// Cost    ~6 us a stereo frame, for its checksums. Source: docs/architecture.md.
#pragma once

#include <utility>

#include "bsp/api/camera.h"
#include "bsp/api/imu.h"
#include "modules/calibration/calibration.h"
#include "modules/door/door_loss.h"
#include "modules/door/door_params.h"
#include "modules/door/image_guard.h"
#include "modules/door/imu_guard.h"

namespace pirvs {

struct DoorFrame {
  TimeNs t = 0;  // on the IMU's clock
  StereoFrame images;
};

// Stamps of one sensor that stepped by more than its period: items were lost, or its clock was set.
struct ClockDoubt {
  TimeNs shift = 0;  // if it was, frames stamped t belong to t + shift; 0: there is no doubt
  TimeNs since = 0;  // the first frame in doubt
  bool is_imus = false;
};

struct DoorItem {
  bool is_frame = false;
  bool broken = false;
  ImuSample imu;
  DoorFrame frame;
};

// Sees everything that comes in, before any of it is judged.
struct DoorTap {
  void* context = nullptr;
  void (*imu)(void*, const ImuSample&) = nullptr;
  void (*frame)(void*, const StereoFrame&) = nullptr;  // its images are valid during the call
};

class Door {
 public:
  void configure(const Calibration& calibration, const DoorParams& params, const DoorTap& tap = {});
  void set_tap(const DoorTap& tap) { tap_ = tap; }
  // A frame handed out stays valid until release().
  Status next(DoorItem& out);
  void release();
  const DoorLosses& losses() const { return losses_; }

  // Who can see the world decides: it was set (frames go on at the right time), or it was not.
  const ClockDoubt& doubt() const { return doubt_; }
  void clock_was_set();
  void clocks_are_right() { doubt_ = ClockDoubt{}; }

 private:
  // A live sensor that gives nothing, by the machine's clock.
  struct Silence {
    TimeNs since = 0;  // 0: the sensor is heard
    bool told = false;

    bool lasts(TimeNs limit);  // asked whenever there was nothing
    bool is_news() { return !std::exchange(told, true); }
  };

  bool fetch_imu();
  bool fetch_frame();
  bool is_late(const DoorFrame& frame, DoorLoss& why) const;
  void drop_frame(DoorLoss why);
  bool imu_may_pass_silent_cameras();
  bool may_be_of_another_time();
  void note_frame_step(TimeNs raw);
  void suspect(TimeNs shift, bool is_imus);
  bool is_from_the_future();
  void hand_out_ahead(DoorItem& out);
  void hand_out(DoorItem& out, const ImuSample& sample, bool broken);

  DoorParams params_;
  DoorTap tap_;
  TimeNs offset_ = 0, break_ = 0, bridge_ = 0, frame_wait_ = 0;
  ImuGuard imu_guard_;
  ImageGuard image_guard_;
  ImuSample last_;  // handed out
  bool has_last_ = false;
  GoodSample ahead_;  // fetched, not handed out
  bool has_ahead_ = false;
  DoorFrame frame_;
  bool has_frame_ = false;
  TimeNs last_frame_t_ = INT64_MIN;
  TimeNs far_back_since_ =
      0;  // sensor time when frames began to come from far back; 0: they do not
  ClockDoubt doubt_;
  TimeNs clock_step_ = 0;
  TimeNs raw_frame_t_ = INT64_MIN, frame_period_ = 0;
  int future_frames_ = 0;  // in a row
  bool imu_ended_ = false, frames_ended_ = false;
  Silence imu_silence_, camera_silence_;
  DoorLosses losses_;
};

}  // namespace pirvs
