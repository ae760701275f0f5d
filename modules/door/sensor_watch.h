// What the driver of one sensor answers: faults, told at most once a second; a sensor that gives
// faults alone is lost, until it gives an item again.
// In      Every arrival that is about the sensor, and ticks.
// Units   ns.
// Errors  Faults, losses and returns are counted by name.
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
    if (lost_ || (told_t_ != INT64_MIN && sensor_t - told_t_ < kTellEvery_ns)) return;
    told_t_ = sensor_t;
    (void)news.events.push_back(what);
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
  TimeNs told_t_ = INT64_MIN;
};

}  // namespace pirvs
