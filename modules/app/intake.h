// Asks all that can come in, and pushes it through the door as arrivals.
// In      bsp::imu_poll, camera_poll, tick_poll; what nobody asks for from an ArrivalSource.
// Out     poll(): one arrival, when the door has nothing left to hand out. drain_imu(): all IMU
//         samples that are there, at any time, so that the door's fresh listener has them at once.
//         Either way the door hands out the same items. IntakeTap sees each arrival before the door
//         judges it. Frames go back to the bsp by release().
// Errors  Faults of a driver are arrivals: the door counts them. After a fault the sensor is asked
//         again after all others, so that one that never stops keeps nobody waiting; a lost one is
//         asked at each tick, and goes on by itself when it answers.
// Cost    A few polls. Belongs to the door's core; release() to whoever has the frame.
// Source  docs/architecture.md, "One way for the data".
#pragma once

#include "bsp/api/tick.h"
#include "modules/door/door.h"

namespace pirvs {

// The drivers that are asked; a test has others.
struct IntakeDrivers {
  Status (*camera)(StereoFrame&) = bsp::camera_poll;
  Status (*imu)(ImuSample&) = bsp::imu_poll;
  Status (*tick)(TimeNs&) = bsp::tick_poll;
};

struct IntakeTap {
  void* context = nullptr;
  void (*arrival)(void*, const Arrival&) = nullptr;  // a frame's images are valid during the call
};

// Commands, fixes, wheel samples, edges, sensors that are lost or back: an inbox, or a recording.
struct ArrivalSource {
  void* context = nullptr;
  bool (*next)(void*, Arrival& out) = nullptr;
};

class Intake {
 public:
  void configure(Door* door, const IntakeTap& tap = {}, const ArrivalSource& inbox = {},
                 const IntakeDrivers& drivers = {});
  void set_tap(const IntakeTap& tap) { tap_ = tap; }

  // False: nothing has come.
  bool poll();
  void drain_imu();
  // As DoorListener::release.
  static void release(void*, const StereoFrame& frame);

 private:
  bool poll_inbox();
  bool poll_sensors();
  bool poll_camera();
  bool poll_imu();
  bool poll_tick();
  bool ask_imu(Arrival& out);
  bool may_ask(Sensor sensor) const;
  void push(const Arrival& arrival);

  Door* door_ = nullptr;
  IntakeTap tap_;
  ArrivalSource inbox_;
  IntakeDrivers drivers_;
  bool ended_[static_cast<int>(Sensor::kCount)] = {};
  bool fault_since_tick_[static_cast<int>(Sensor::kCount)] = {};
  bool camera_faulted_last_ = false;  // of the faults, the newest was the camera's
  Arrival pending_;                   // of the IMU, met by drain_imu(): it must wait for poll()
  bool has_pending_ = false;
};

}  // namespace pirvs
