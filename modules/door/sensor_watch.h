// What the driver of one sensor answers: faults, and frames that it lost, each told at most once a
// second; a sensor that gives faults alone is lost, until it gives an item again.
// In      Every arrival that is about the sensor, and ticks.
// Units   ns.
// Errors  Faults, frames lost, losses and returns are counted by name.
// Cost    none to speak of.
// Source  docs/faults.md.
#pragma once

#include "core/base/status.h"
#include "core/store/fixed_vector.h"
#include "modules/door/arrival.h"
#include "modules/door/door_loss.h"
#include "modules/door/silence.h"

namespace pirvs {

// What is counted, and what of it health shall tell.
struct DoorNews {
  DoorLosses losses;
  FixedVector<DoorLoss, 4> events;  // one arrival makes no more

  void tell(DoorLoss what) {
    losses.add(what);
    (void)events.push_back(what);
  }
};

class SensorWatch {
 public:
  void configure(Sensor sensor, TimeNs lost_after) {
    is_imu_ = sensor == Sensor::kImu;
    lost_after_ = lost_after;
  }
  // sensor_t: as far as sensor time has come.
  void fault(Status status, TimeNs sensor_t, DoorNews& news) {
    faulty_ = true;
    const DoorLoss what = name_of(status);
    news.losses.add(what);
    if (!lost_) tell_now_and_then(what, sensor_t, fault_told_t_, news);
  }
  // The driver of the cameras lost so many frames.
  void lost_frames(uint32_t count, TimeNs sensor_t, DoorNews& news) {
    if (count == 0) return;
    news.losses.count[static_cast<int>(DoorLoss::kFramesLost)] += count;
    tell_now_and_then(DoorLoss::kFramesLost, sensor_t, frames_told_t_, news);
  }
  void tick(TimeNs t, DoorNews& news) {
    if (!faulty_) return;
    faults_alone_.tick(t);
    if (faults_alone_.lasts(lost_after_)) lose(news);
  }
  // An item has come, or the driver says that its device is back.
  void heard(DoorNews& news) {
    faulty_ = false;
    faults_alone_.end();
    if (lost_) news.tell(is_imu_ ? DoorLoss::kImuBack : DoorLoss::kCameraBack);
    lost_ = false;
  }
  void lose(DoorNews& news) {
    if (!lost_) news.tell(is_imu_ ? DoorLoss::kImuLostDevice : DoorLoss::kCameraLostDevice);
    lost_ = true;
  }
  void end() { ended_ = true; }

  bool lost() const { return lost_; }
  bool ended() const { return ended_; }

 private:
  static constexpr TimeNs kTellEvery_ns = 1'000'000'000;

  static void tell_now_and_then(DoorLoss what, TimeNs t, TimeNs& told_t, DoorNews& news) {
    if (told_t != INT64_MIN && t - told_t < kTellEvery_ns) return;
    told_t = t;
    (void)news.events.push_back(what);
  }
  DoorLoss name_of(Status status) const {
    if (status == Status::kBusFault) {
      return is_imu_ ? DoorLoss::kImuBusFault : DoorLoss::kCameraBusFault;
    }
    if (status == Status::kTimeout) {
      return is_imu_ ? DoorLoss::kImuTimeout : DoorLoss::kCameraTimeout;
    }
    return is_imu_ ? DoorLoss::kImuBadData : DoorLoss::kCameraBadData;
  }

  bool is_imu_ = true;
  TimeNs lost_after_ = 0;
  bool faulty_ = false;  // its last answer was a fault
  bool lost_ = false, ended_ = false;
  Silence faults_alone_;
  TimeNs fault_told_t_ = INT64_MIN, frames_told_t_ = INT64_MIN;
};

}  // namespace pirvs
