// The sensor door: one stream, ordered by sensor time, on the IMU's clock, of what the sensors can
// have sensed. A pure state machine: the items depend on the sequence of arrivals alone.
// In      push(): arrivals. An IMU sample may be pushed at any time; anything else only after
//         next() has said kEmpty, a frame only while wants_frame().
// Out     next(): IMU samples, then a frame once a sample exactly at its time has been handed out
//         (interpolated when the IMU has none there). A frame may lack one image or both. GNSS
//         fixes, wheel samples and edges come before the first sample that is later, none from
//         before the IMU's very first one; commands and events at once. broken: time does not go
//         on from the item before; whoever integrates must start anew.
//         DoorListener::fresh: each good IMU sample at once, before it waits for a frame.
//         Samples are judged as measured, and handed out without the scale, misalignment and
//         biases of their calibration.
// Units   ns, rad/s, m/s^2.
// Errors  kEmpty: nothing until more arrives. kStale: the sensors have ended. Bad input is dropped
//         and counted, faults of a driver are counted: docs/faults.md. Cameras that stay silent
//         delay the IMU by frame_wait_s of ticks, or by kImuQueue samples, at most.
// Cost    ~6 us a stereo frame, for its checksums.
//         Calls belong to one core, but for this: while a frame is lent, push() of IMU samples may
//         go on there while another core calls in_doubt(), judge_clocks() and, last, release().
// Source  docs/architecture.md.
#pragma once

#include "core/store/ring.h"
#include "modules/calibration/calibration.h"
#include "modules/door/arrival.h"
#include "modules/door/aside_queue.h"
#include "modules/door/clock_watch.h"
#include "modules/door/door_item.h"
#include "modules/door/door_params.h"
#include "modules/door/image_guard.h"
#include "modules/door/imu_guard.h"
#include "modules/door/sensor_watch.h"
#include "modules/door/silence.h"

namespace pirvs {

struct DoorListener {
  void* context = nullptr;
  // From push(). broken: time does not go on from the sample before.
  void (*fresh)(void*, const ImuSample&, bool broken) = nullptr;
  // The frame is needed no longer: dropped, or release() was called.
  void (*release)(void*, const StereoFrame&) = nullptr;
};

class Door {
 public:
  // Good samples that may wait, at 1 kHz.
  static constexpr size_t kImuQueue = 150    // for a frame: frame_wait_s
                                      + 250  // while a step of tracking, on one core mapping, runs
                                      + 100  // between two frames of slow cameras
                                      + 2;   // released by the IMU guard in one push
  void configure(const Calibration& calibration, const DoorParams& params,
                 const DoorListener& listener = {});

  void push(const Arrival& arrival);
  bool wants_imu() const { return imu_queue_.size() + 2 <= kImuQueue; }
  bool wants_frame() const { return frame_state_ == FrameState::kNone; }
  size_t samples_waiting() const { return imu_queue_.size(); }
  bool is_lost(Sensor sensor) const { return watch_of(sensor).lost(); }

  Status next(DoorItem& out);
  // The frame that was handed out is valid until release(); no other call of next() before.
  void release();

  const DoorLosses& losses() const { return news_.losses; }
  // Of stamps at t: nothing sensed then may get into the map.
  bool in_doubt(TimeNs t) const { return watch_.in_doubt(t); }
  // With each frame's tracks, after they were followed to it.
  ClockVerdict judge_clocks(const ClockCheck::Frame& frame);
  ClockWatch& watch() { return watch_; }
  // A clock was set, as judge_clocks() finds out.
  void clock_was_set();

 private:
  enum class FrameState : uint8_t { kNone, kHeld, kLent };
  enum class Turn : uint8_t { kWait, kEnd, kDropFrame, kFrame, kBreak, kSample, kSampleAtFrame };

  const SensorWatch& watch_of(Sensor sensor) const { return sensors_[static_cast<int>(sensor)]; }
  void push_imu(const Arrival& arrival);
  void push_frame(const StereoFrame& frame);
  void push_tick(TimeNs t);

  bool take_at_once(DoorItem& out);
  Turn decide(const GoodSample* imu, DoorLoss& why);
  Turn decide_without_imu(DoorLoss& why);
  bool is_late(const GoodSample* imu, DoorLoss& why) const;
  bool imu_may_pass();
  void hand_out_frame(DoorItem& out);
  void hand_out_sample(Turn turn, const GoodSample& next, DoorItem& out);
  void drop_frame(DoorLoss why);

  DoorParams params_;
  DoorListener listener_;
  TimeNs bridge_ = 0, frame_wait_ = 0, break_ = 0;
  ImuGuard imu_guard_;
  ImuCorrection imu_correction_;
  ImageGuard image_guard_;
  ClockWatch watch_;
  Ring<GoodSample, kImuQueue> imu_queue_;
  ImuSample last_;  // handed out
  bool has_last_ = false;
  DoorFrame frame_;
  FrameState frame_state_ = FrameState::kNone;
  TimeNs last_frame_t_ = INT64_MIN;
  SensorWatch sensors_[static_cast<int>(Sensor::kCount)];
  Silence imu_silence_, camera_silence_;
  bool cameras_silent_ = false;
  AsideQueue aside_;
  TimeNs imu_begin_ = AsideQueue::kImuToCome;  // INT64_MIN: time was broken since
  DoorNews news_;
  Command command_;
  bool has_command_ = false;
};

}  // namespace pirvs
