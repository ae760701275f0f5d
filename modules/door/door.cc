#include "modules/door/door.h"

#include <cmath>
#include <iterator>

#include "bsp/api/clock.h"
#include "modules/imu/imu_sample.h"

namespace pirvs {
namespace {

constexpr TimeNs kAskImu_ns = 100'000'000;  // a frame interval of slow cameras
constexpr int kFutureFrames = 3;            // in a row: no accident

}  // namespace

const char* name(DoorLoss loss) {
  static constexpr const char* kNames[] = {"imu_not_finite",
                                           "imu_out_of_range",
                                           "imu_stamp_impossible",
                                           "imu_saturated",
                                           "imu_spike",
                                           "imu_stuck",
                                           "imu_stamp_ahead",
                                           "imu_backwards",
                                           "imu_lost",
                                           "imu_gap",
                                           "imu_silent",
                                           "imu_clock_back",
                                           "stream_broken",
                                           "frame_stamp_impossible",
                                           "frame_backwards",
                                           "frame_before_imu",
                                           "frame_without_imu",
                                           "frame_ahead",
                                           "camera_missing",
                                           "camera_late",
                                           "camera_frozen",
                                           "camera_wrong_size",
                                           "camera_silent",
                                           "camera_gap",
                                           "camera_clock_set",
                                           "imu_clock_set"};
  static_assert(std::size(kNames) == static_cast<size_t>(DoorLoss::kCount));
  return kNames[static_cast<size_t>(loss)];
}

void Door::configure(const Calibration& calibration, const DoorParams& params, const DoorTap& tap) {
  *this = Door{};
  params_ = params;
  tap_ = tap;
  offset_ = calibration.camera_time_offset_ns;
  break_ = from_seconds(static_cast<double>(params.break_s));
  bridge_ = from_seconds(static_cast<double>(params.bridge_s));
  frame_wait_ = from_seconds(static_cast<double>(params.frame_wait_s));
  clock_step_ = from_seconds(static_cast<double>(params.clock_step_s));
  imu_guard_.configure(params);
  image_guard_.configure(calibration.camera, calibration.cameras, params);
}

bool Door::Silence::lasts(TimeNs limit) {
  const TimeNs now = bsp::now();
  if (since == 0) since = now;
  return now - since >= limit;
}

bool Door::fetch_imu() {
  while (!has_ahead_) {
    has_ahead_ = imu_guard_.get(ahead_);
    if (has_ahead_ && ahead_.step != 0) suspect(ahead_.step, true);
    if (has_ahead_ || imu_ended_) return has_ahead_;
    ImuSample raw;
    const Status status = bsp::imu_poll(raw);
    if (status == Status::kStale) {
      imu_ended_ = true;
      imu_guard_.finish(losses_);
    }
    if (status == Status::kFull) losses_.add(DoorLoss::kImuLost);  // this sample is good
    if (status != Status::kOk && status != Status::kFull) return false;
    imu_silence_ = Silence{};
    if (tap_.imu != nullptr) tap_.imu(tap_.context, raw);
    imu_guard_.put(raw, losses_);
  }
  return true;
}

bool Door::fetch_frame() {
  if (has_frame_) return true;
  while (!has_frame_) {
    if (frames_ended_) return false;
    const Status status = bsp::camera_poll(frame_.images);
    if (status == Status::kStale) frames_ended_ = true;
    if (status != Status::kOk) return false;
    if (tap_.frame != nullptr) tap_.frame(tap_.context, frame_.images);
    has_frame_ = true;
    const TimeNs raw = frame_.images.t;
    if (!is_stamp(raw) || !is_stamp(raw + offset_)) drop_frame(DoorLoss::kFrameStampImpossible);
  }
  note_frame_step(frame_.images.t);
  frame_.t = frame_.images.t + offset_;
  camera_silence_ = Silence{};
  return true;
}

void Door::note_frame_step(TimeNs raw) {
  const bool first = raw_frame_t_ == INT64_MIN;
  const TimeNs step = first ? 0 : raw - raw_frame_t_;
  raw_frame_t_ = raw;
  if (frame_period_ > 0 && (step < -clock_step_ || step - frame_period_ > clock_step_)) {
    if (step > 0) losses_.add(DoorLoss::kCameraGap);
    suspect(frame_period_ - step, false);
  }
  // From above towards the true one, whatever is lost.
  if (frame_period_ == 0) frame_period_ = step > 0 && step < clock_step_ ? step : 0;
  const bool near = step > 0 && step < frame_period_ + frame_period_ / 2;
  if (near) frame_period_ += (step - frame_period_) / 8;
}

// When both clocks are set together, the second step takes back the first one's doubt; so does a
// stamp that is right again.
void Door::suspect(TimeNs shift, bool is_imus) {
  const bool opposite = (shift < 0) != (doubt_.shift < 0);
  if (doubt_.shift != 0 && opposite) shift += doubt_.shift;
  doubt_ = ClockDoubt{};
  const bool small = shift >= -clock_step_ && shift <= clock_step_;
  if (small || !is_stamp(shift) || !is_stamp(offset_ + shift)) return;
  doubt_.shift = shift;
  doubt_.is_imus = is_imus;
}

void Door::clock_was_set() {
  losses_.add(doubt_.is_imus ? DoorLoss::kImuClockSet : DoorLoss::kCameraClockSet);
  offset_ += doubt_.shift;
  frame_.t = frame_.images.t + offset_;
  last_frame_t_ = INT64_MIN;
  far_back_since_ = 0;
  doubt_ = ClockDoubt{};
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
  if (!camera_silence_.lasts(frame_wait_)) return false;
  if (camera_silence_.is_news()) losses_.add(DoorLoss::kCameraSilent);
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

// Live, the newest sample is now: a frame cannot be long after it. Several that are, and would not
// be if the cameras' clock had been set, say that it has.
bool Door::is_from_the_future() {
  const TimeNs ahead = has_last_ ? frame_.t - last_.t : 0;
  if (ahead <= break_) return false;
  if (++future_frames_ < kFutureFrames || doubt_.shift >= 0) return true;
  if (ahead > clock_step_ - doubt_.shift) return true;
  clock_was_set();
  return false;
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
      future_frames_ = 0;
      if (doubt_.shift != 0 && doubt_.since == 0) doubt_.since = frame_.t;
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
      if (!imu_ended_) {
        if (imu_silence_.lasts(bridge_) && imu_silence_.is_news()) {
          losses_.add(DoorLoss::kImuSilent);
          return Status::kTimeout;
        }
        if (!(frame && is_from_the_future())) return Status::kEmpty;
      }
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
    hand_out(out, cut ? interpolated(last_, ahead_.sample, frame_.t) : ahead_.sample, false);
    return Status::kOk;
  }
}

void Door::release() {
  bsp::camera_release();
  has_frame_ = false;
}

}  // namespace pirvs
