#include "modules/door/clock_watch.h"

namespace pirvs {
namespace {

constexpr TimeNs kAskImu_ns = 100'000'000;      // a frame interval of slow cameras
constexpr int kFutureFrames = 3;                // in a row: no accident
constexpr TimeNs kDoubtMax_ns = 2'000'000'000;  // undecided for longer: a body that hardly turns

}  // namespace

void ClockWatch::configure(const Calibration& calibration, const DoorParams& params) {
  check_.configure(calibration.camera);
  break_ = from_seconds(static_cast<double>(params.break_s));
  clock_step_ = from_seconds(static_cast<double>(params.clock_step_s));
  offset_ = calibration.camera_time_offset_ns;
}

void ClockWatch::frame_came(TimeNs camera_stamp, DoorLosses& losses) {
  const bool first = raw_frame_t_ == INT64_MIN;
  const TimeNs step = first ? 0 : camera_stamp - raw_frame_t_;
  raw_frame_t_ = camera_stamp;
  if (frame_period_ > 0 && (step < -clock_step_ || step - frame_period_ > clock_step_)) {
    if (step > 0) losses.add(DoorLoss::kCameraGap);
    suspect(frame_period_ - step, false);
  }
  // The estimate of the period only falls towards the true one: lost frames cannot raise it.
  if (frame_period_ == 0) frame_period_ = step > 0 && step < clock_step_ ? step : 0;
  const bool near = step > 0 && step < frame_period_ + frame_period_ / 2;
  if (near) frame_period_ += (step - frame_period_) / 8;
}

// When both clocks are set together, the second step takes back the first one's doubt; so does a
// stamp that is right again.
void ClockWatch::suspect(TimeNs shift, bool is_imus) {
  const bool opposite = (shift < 0) != (shift_ < 0);
  if (shift_ != 0 && opposite) shift += shift_;
  reject_step();
  const bool small = shift >= -clock_step_ && shift <= clock_step_;
  if (small || !is_stamp(shift) || !is_stamp(offset_ + shift)) return;
  shift_ = shift;
  is_imus_ = is_imus;
}

void ClockWatch::restart() {
  far_back_since_ = 0;
  check_.reset();
}

bool ClockWatch::must_wait_for_imu(TimeNs t, TimeNs imu_t) {
  if (imu_t - t <= break_) return false;
  if (far_back_since_ == 0) far_back_since_ = imu_t;
  return imu_t - far_back_since_ < kAskImu_ns;
}

ClockWatch::Ahead ClockWatch::frame_ahead(TimeNs t, TimeNs imu_t) {
  const TimeNs ahead = t - imu_t;
  if (ahead <= break_) return Ahead::kPossible;
  if (++future_frames_ < kFutureFrames || shift_ >= 0) return Ahead::kImpossible;
  return ahead > clock_step_ - shift_ ? Ahead::kImpossible : Ahead::kClockSet;
}

void ClockWatch::frame_handed_out(TimeNs t) {
  far_back_since_ = 0;
  future_frames_ = 0;
  if (shift_ != 0 && doubt_since_ == 0) doubt_since_ = t;
}

bool ClockWatch::in_doubt(TimeNs t) const {
  if (shift_ == 0) return false;
  const TimeNs delay = shift_ > 0 ? shift_ : 0;  // of the samples that decide
  return doubt_since_ == 0 || t - doubt_since_ <= kDoubtMax_ns + delay;
}

void ClockWatch::accept_step(DoorLosses& losses) {
  losses.add(is_imus_ ? DoorLoss::kImuClockSet : DoorLoss::kCameraClockSet);
  offset_ += shift_;
  far_back_since_ = 0;
  reject_step();
}

void ClockWatch::reject_step() {
  shift_ = doubt_since_ = 0;
  is_imus_ = false;
}

ClockVerdict ClockWatch::judge(const ClockCheck::Frame& frame) {
  switch (check_.frame(frame, shift_)) {
    case ClockCheck::Verdict::kOpen:
      break;
    case ClockCheck::Verdict::kHold:
      reject_step();
      break;
    case ClockCheck::Verdict::kSet:
      return is_imus_ ? ClockVerdict::kImuSet : ClockVerdict::kCamerasSet;
  }
  return ClockVerdict::kRight;
}

}  // namespace pirvs
