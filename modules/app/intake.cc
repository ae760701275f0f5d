#include "modules/app/intake.h"

namespace pirvs {

void Intake::configure(Door* door, const IntakeTap& tap, const ArrivalSource& inbox,
                       const IntakeDrivers& drivers) {
  *this = Intake{};
  door_ = door;
  tap_ = tap;
  inbox_ = inbox;
  drivers_ = drivers;
}

// What is asked next depends on what was pushed, and on nothing else: a replay asks the same.
void Intake::push(const Arrival& arrival) {
  const int i = static_cast<int>(arrival.sensor);
  if (arrival.kind == ArrivalKind::kFault) {
    fault_since_tick_[i] = true;
    camera_faulted_last_ = arrival.sensor == Sensor::kCamera;
  }
  if (arrival.kind == ArrivalKind::kEnd) ended_[i] = true;
  if (arrival.kind == ArrivalKind::kTick) {
    for (bool& fault : fault_since_tick_) fault = false;
  }
  if (tap_.arrival != nullptr) tap_.arrival(tap_.context, arrival);
  door_->push(arrival);
}

bool Intake::poll() {
  if (poll_inbox()) return true;
  const bool any_fault = fault_since_tick_[0] || fault_since_tick_[1];
  if (any_fault && poll_tick()) return true;  // or a driver with faults alone would hold time up
  return poll_sensors() || (!any_fault && poll_tick());
}

// A replay gives a frame only once the IMU has come to it, so the cameras are asked first.
bool Intake::poll_sensors() {
  const int camera = static_cast<int>(Sensor::kCamera);
  if (fault_since_tick_[camera] && camera_faulted_last_) return poll_imu() || poll_camera();
  return poll_camera() || poll_imu();
}

bool Intake::poll_inbox() {
  Arrival arrival;
  if (inbox_.next == nullptr || !inbox_.next(inbox_.context, arrival)) return false;
  push(arrival);
  return true;
}

// A sensor that is lost answers with a fault each time: one for each tick will do.
bool Intake::may_ask(Sensor sensor) const {
  const int i = static_cast<int>(sensor);
  return !ended_[i] && !(door_->is_lost(sensor) && fault_since_tick_[i]);
}

bool Intake::poll_camera() {
  if (!door_->wants_frame() || !may_ask(Sensor::kCamera)) return false;
  StereoFrame frame;
  const Status status = drivers_.camera(frame);
  if (status == Status::kEmpty) return false;
  if (status == Status::kOk) {
    push(arrival_of(frame));
  } else if (status == Status::kStale) {
    push(arrival_of(ArrivalKind::kEnd, Sensor::kCamera));
  } else {
    push(arrival_of(ArrivalKind::kFault, Sensor::kCamera, status));
  }
  return true;
}

bool Intake::ask_imu(Arrival& out) {
  if (!door_->wants_imu()) return false;
  ImuSample sample;
  const Status status = drivers_.imu(sample);
  if (status == Status::kEmpty) return false;
  if (status == Status::kOk || status == Status::kFull) {
    out = arrival_of(sample, status == Status::kFull);
  } else if (status == Status::kStale) {
    out = arrival_of(ArrivalKind::kEnd, Sensor::kImu);
  } else {
    out = arrival_of(ArrivalKind::kFault, Sensor::kImu, status);
  }
  return true;
}

bool Intake::poll_imu() {
  if (!may_ask(Sensor::kImu)) return false;
  if (has_pending_) {
    has_pending_ = false;
    push(pending_);
    return true;
  }
  Arrival arrival;
  if (!ask_imu(arrival)) return false;
  push(arrival);
  return true;
}

// What is no sample waits for poll(), and all that comes after it.
void Intake::drain_imu() {
  Arrival arrival;
  while (!has_pending_ && may_ask(Sensor::kImu) && !door_->is_lost(Sensor::kImu) &&
         ask_imu(arrival)) {
    if (arrival.kind == ArrivalKind::kImu) {
      push(arrival);
    } else {
      pending_ = arrival;
      has_pending_ = true;
    }
  }
}

bool Intake::poll_tick() {
  TimeNs t = 0;
  if (drivers_.tick(t) != Status::kOk) return false;
  push(tick_at(t));
  return true;
}

void Intake::release(void*, const StereoFrame& frame) { bsp::camera_release(frame.id); }

}  // namespace pirvs
