#include "modules/app/door.h"

#include <cmath>
#include <iterator>

#include "bsp/api/clock.h"

namespace pirvs {
namespace {

constexpr TimeNs kAskImu_ns = 100'000'000;  // a frame interval of slow cameras

ImuSample between(const ImuSample& a, const ImuSample& b, TimeNs t) {
  const double s = to_seconds(t - a.t) / to_seconds(b.t - a.t);
  ImuSample out;
  out.t = t;
  out.w_B = a.w_B + s * (b.w_B - a.w_B);
  out.f_B = a.f_B + s * (b.f_B - a.f_B);
  return out;
}

}  // namespace

const char* name(DoorLoss loss) {
  static constexpr const char* kNames[] = {
      "imu_not_finite",   "imu_out_of_range",  "imu_saturated",     "imu_spike",
      "imu_stuck",        "imu_stamp_ahead",   "imu_backwards",     "imu_lost",
      "imu_gap",          "imu_clock_back",    "stream_broken",     "frame_backwards",
      "frame_before_imu", "frame_without_imu", "frame_ahead",       "camera_missing",
      "camera_late",      "camera_frozen",     "camera_wrong_size", "camera_silent"};
  static_assert(std::size(kNames) == static_cast<size_t>(DoorLoss::kCount));
  return kNames[static_cast<size_t>(loss)];
}

void Door::configure(const Calibration& calibration, const DoorParams& params, const DoorTap& tap) {
  *this = Door{};
  params_ = params;
  tap_ = tap;
  offset_ = calibration.camera_time_offset;
  break_ = from_seconds(static_cast<double>(params.break_s));
  frame_wait_ = from_seconds(static_cast<double>(params.frame_wait_s));
  imu_guard_.configure(params);
  image_guard_.configure(calibration.camera, calibration.cameras, params);
}

bool Door::fetch_imu() {
  while (!has_ahead_) {
    has_ahead_ = imu_guard_.get(ahead_);
    if (has_ahead_ || imu_ended_) return has_ahead_;
    ImuSample raw;
    const Status status = bsp::imu_poll(raw);
    if (status == Status::kStale) {
      imu_ended_ = true;
      imu_guard_.finish(losses_);
    }
    if (status == Status::kFull) losses_.add(DoorLoss::kImuLost);  // this sample is good
    if (status != Status::kOk && status != Status::kFull) return false;
    if (tap_.imu != nullptr) tap_.imu(tap_.context, raw);
    imu_guard_.put(raw, losses_);
  }
  return true;
}

bool Door::fetch_frame() {
  if (has_frame_ || frames_ended_) return has_frame_;
  const Status status = bsp::camera_poll(frame_.images);
  if (status == Status::kStale) frames_ended_ = true;
  if (status != Status::kOk) return false;
  if (tap_.frame != nullptr) tap_.frame(tap_.context, frame_.images);
  frame_.t = frame_.images.t + offset_;
  has_frame_ = true;
  silent_since_ = 0;
  silence_counted_ = false;
  return true;
}

void Door::drop_frame(DoorLoss why) {
  losses_.add(why);
  release();
}

// A frame that comes too late to be used, seen from what has been handed out.
bool Door::is_late(const DoorFrame& frame, DoorLoss& why) const {
  if (frame.t <= last_frame_t_) {
    why = DoorLoss::kFrameBackwards;
    return true;
  }
  why = DoorLoss::kFrameBeforeImu;
  return has_last_ ? frame.t < last_.t : has_ahead_ && frame.t < ahead_.sample.t;
}

// Nobody has seen a frame for a while: dead reckoning must go on.
bool Door::imu_may_pass_silent_cameras() {
  if (frames_ended_) return true;
  const TimeNs now = bsp::now();
  if (silent_since_ == 0) silent_since_ = now;
  if (now - silent_since_ < frame_wait_) return false;
  if (!silence_counted_) losses_.add(DoorLoss::kCameraSilent);
  silence_counted_ = true;
  return true;
}

void Door::hand_out(DoorItem& out, const ImuSample& sample, bool broken) {
  out.is_frame = false;
  out.broken = broken;
  out.imu = sample;
  last_ = sample;
  has_last_ = true;
}

// A frame from far back, as when somebody has set the clock: before it and those like it are
// dropped, the IMU's next samples must say whether its stamps have gone back, too.
bool Door::may_be_of_another_time() {
  if (!has_last_ || last_.t - frame_.t <= break_) return false;
  if (far_back_since_ == 0) far_back_since_ = last_.t;
  return last_.t - far_back_since_ < kAskImu_ns;
}

void Door::hand_out_ahead(DoorItem& out) {
  has_ahead_ = false;
  hand_out(out, ahead_.sample, ahead_.broken);
}

Status Door::next(DoorItem& out) {
  for (;;) {
    const bool imu = fetch_imu();
    const bool frame = fetch_frame();
    if (frame && has_last_ && frame_.t == last_.t && frame_.t > last_frame_t_) {
      image_guard_.check(frame_.images, losses_);
      out.is_frame = true;
      out.broken = false;
      out.frame = frame_;
      last_frame_t_ = frame_.t;
      far_back_since_ = 0;
      return Status::kOk;
    }
    if (imu && ahead_.broken) {  // what was before has nothing to say about what comes
      last_frame_t_ = INT64_MIN;
      far_back_since_ = 0;
      const bool back = ahead_.sample.t < last_.t;
      if (back && frame && frame_.t - ahead_.sample.t > break_) drop_frame(DoorLoss::kFrameAhead);
      hand_out_ahead(out);
      return Status::kOk;
    }
    DoorLoss why;
    if (frame && is_late(frame_, why)) {
      if (imu && may_be_of_another_time()) {
        hand_out_ahead(out);
        return Status::kOk;
      }
      drop_frame(why);
      continue;
    }
    if (!imu) {
      // Live, the newest sample is now: a frame cannot be long after it.
      const bool from_the_future = frame && has_last_ && frame_.t - last_.t > break_;
      if (!imu_ended_ && !from_the_future) return Status::kEmpty;
      if (frame) {
        drop_frame(imu_ended_ ? DoorLoss::kFrameWithoutImu : DoorLoss::kFrameAhead);
        continue;
      }
      return frames_ended_ ? Status::kStale : Status::kEmpty;
    }
    // Without a frame in sight the IMU must wait, or the frame's own sample could not be made.
    if (!frame && !imu_may_pass_silent_cameras()) return Status::kEmpty;
    const bool cut = frame && ahead_.sample.t > frame_.t && has_last_;
    has_ahead_ = cut;
    hand_out(out, cut ? between(last_, ahead_.sample, frame_.t) : ahead_.sample, false);
    return Status::kOk;
  }
}

void Door::release() {
  bsp::camera_release();
  has_frame_ = false;
}

}  // namespace pirvs
