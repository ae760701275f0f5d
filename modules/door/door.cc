#include "modules/door/door.h"

#include <new>
#include <utility>

#include "modules/imu/imu_sample.h"

namespace pirvs {

void Door::configure(const Calibration& calibration, const DoorParams& params,
                     const DoorListener& listener) {
  // Everything anew, in place, since no stack could hold it.
  this->~Door();
  new (this) Door;
  params_ = params;
  listener_ = listener;
  bridge_ = from_seconds(static_cast<double>(params.bridge_s));
  frame_wait_ = from_seconds(static_cast<double>(params.frame_wait_s));
  break_ = from_seconds(static_cast<double>(params.break_s));
  for (const Sensor sensor : {Sensor::kImu, Sensor::kCamera}) {
    sensors_[static_cast<int>(sensor)].configure(sensor,
                                                 from_seconds(static_cast<double>(params.lost_s)));
  }
  imu_guard_.configure(params);
  imu_correction_.configure(calibration.imu_intrinsics);
  image_guard_.configure(calibration.camera, calibration.cameras, params);
  watch_.configure(calibration, params);
}

void Door::push(const Arrival& arrival) {
  SensorWatch& sensor = sensors_[static_cast<int>(arrival.sensor)];
  switch (arrival.kind) {
    case ArrivalKind::kImu:
      return push_imu(arrival);
    case ArrivalKind::kFrame:
      return push_frame(arrival.frame);
    case ArrivalKind::kGnss:
    case ArrivalKind::kWheel:
    case ArrivalKind::kEdge:
      if (arrival.after_loss) news_.losses.add(DoorLoss::kEdgesLost);
      return aside_.push(arrival, imu_begin_, news_.losses);
    case ArrivalKind::kCommand:
      PIRVS_ASSERT(!has_command_);
      command_ = arrival.command;
      has_command_ = true;
      return;
    case ArrivalKind::kTick:
      return push_tick(arrival.t);
    case ArrivalKind::kFault:
      return sensor.fault(arrival.status, last_.t, news_);
    case ArrivalKind::kLost:
      return sensor.lose(news_);
    case ArrivalKind::kBack:
      return sensor.heard(news_);
    case ArrivalKind::kEnd:
      sensor.end();
      if (arrival.sensor == Sensor::kImu) imu_guard_.finish(news_.losses);
      return;
    case ArrivalKind::kCount:
      break;
  }
  PIRVS_ASSERT(!"no such arrival");
}

void Door::push_imu(const Arrival& arrival) {
  imu_silence_.end();
  sensors_[static_cast<int>(Sensor::kImu)].heard(news_);
  if (arrival.after_loss) news_.losses.add(DoorLoss::kImuLost);
  if (!wants_imu()) return news_.losses.add(DoorLoss::kImuQueueFull);
  imu_guard_.put(arrival.imu, news_.losses);
  GoodSample good;
  while (imu_guard_.get(good)) {
    imu_correction_.apply(good.sample);
    if (imu_begin_ == AsideQueue::kImuToCome) {
      imu_begin_ = good.sample.t;
      aside_.drop_before(imu_begin_, news_.losses);
    }
    (void)imu_queue_.push(good);  // wants_imu(): there is room
    if (listener_.fresh != nullptr) listener_.fresh(listener_.context, good.sample, good.broken);
  }
}

void Door::push_frame(const StereoFrame& frame) {
  PIRVS_ASSERT(wants_frame());
  SensorWatch& sensor = sensors_[static_cast<int>(Sensor::kCamera)];
  sensor.heard(news_);
  sensor.lost_frames(frame.lost_before, last_.t, news_);
  frame_.images = frame;
  frame_state_ = FrameState::kHeld;
  if (!is_stamp(frame.t) || !is_stamp(watch_.to_imu_clock(frame.t))) {
    return drop_frame(DoorLoss::kFrameStampImpossible);
  }
  watch_.frame_came(frame.t, news_.losses);
  frame_.t = watch_.to_imu_clock(frame.t);
  camera_silence_.end();
  cameras_silent_ = false;
}

void Door::push_tick(TimeNs t) {
  if (frame_state_ == FrameState::kNone) camera_silence_.tick(t);
  if (imu_queue_.size() == 0 && !watch_of(Sensor::kImu).ended()) {
    imu_silence_.tick(t);
    if (imu_silence_.lasts(bridge_) && imu_silence_.is_news()) news_.tell(DoorLoss::kImuSilent);
  }
  for (SensorWatch& sensor : sensors_) sensor.tick(t, news_);
}

Status Door::next(DoorItem& out) {
  PIRVS_ASSERT(frame_state_ != FrameState::kLent);
  if (take_at_once(out) || (has_last_ && aside_.take(last_.t, out))) return Status::kOk;
  for (;;) {
    GoodSample* const imu = imu_queue_.front();
    if (imu != nullptr && imu->step != 0) watch_.imu_stepped(std::exchange(imu->step, 0));
    DoorLoss why;
    const Turn turn = decide(imu, why);
    switch (turn) {
      case Turn::kWait:
        return Status::kEmpty;
      case Turn::kEnd:
        if (imu_begin_ == AsideQueue::kImuToCome) aside_.drop_before(INT64_MAX, news_.losses);
        return aside_.take(INT64_MAX, out) ? Status::kOk : Status::kStale;
      case Turn::kDropFrame:
        drop_frame(why);
        break;
      case Turn::kFrame:
        hand_out_frame(out);
        return Status::kOk;
      case Turn::kBreak:  // what came before a break goes before it, whatever its stamp
        if (!aside_.take(INT64_MAX, out)) hand_out_sample(turn, *imu, out);
        return Status::kOk;
      case Turn::kSample:
        if (!aside_.take(imu->sample.t, out)) hand_out_sample(turn, *imu, out);
        return Status::kOk;
      case Turn::kSampleAtFrame:
        if (!aside_.take(frame_.t, out)) hand_out_sample(turn, *imu, out);
        return Status::kOk;
    }
  }
}

bool Door::take_at_once(DoorItem& out) {
  FixedVector<DoorLoss, 4>& events = news_.events;
  if (!events.empty()) {
    out.kind = DoorItemKind::kEvent;
    out.event = events[0];
    for (size_t i = 1; i < events.size(); ++i) events[i - 1] = events[i];
    events.pop_back();
    return true;
  }
  if (!has_command_) return false;
  has_command_ = false;
  out.kind = DoorItemKind::kCommand;
  out.command = command_;
  return true;
}

Door::Turn Door::decide(const GoodSample* imu, DoorLoss& why) {
  const bool frame = frame_state_ == FrameState::kHeld;
  if (frame && has_last_ && frame_.t == last_.t && frame_.t > last_frame_t_) return Turn::kFrame;
  if (imu != nullptr && imu->broken) {
    // A frame of the time before a clock was set back; others may wait for the samples to come.
    const bool back = has_last_ && imu->sample.t < last_.t;
    why = DoorLoss::kFrameAhead;
    const bool of_before = back && frame && frame_.t - imu->sample.t > break_;
    return of_before ? Turn::kDropFrame : Turn::kBreak;
  }
  if (frame && is_late(imu, why)) {
    const bool wait = imu != nullptr && has_last_ && watch_.must_wait_for_imu(frame_.t, last_.t);
    return wait ? Turn::kSample : Turn::kDropFrame;
  }
  if (imu == nullptr) return decide_without_imu(why);
  if (!frame) return imu_may_pass() ? Turn::kSample : Turn::kWait;
  return imu->sample.t > frame_.t && has_last_ ? Turn::kSampleAtFrame : Turn::kSample;
}

Door::Turn Door::decide_without_imu(DoorLoss& why) {
  const bool frame = frame_state_ == FrameState::kHeld;
  if (watch_of(Sensor::kImu).ended()) {
    why = DoorLoss::kFrameWithoutImu;
    if (frame) return Turn::kDropFrame;
    return watch_of(Sensor::kCamera).ended() ? Turn::kEnd : Turn::kWait;
  }
  if (!frame || !has_last_) return Turn::kWait;
  why = DoorLoss::kFrameAhead;
  switch (watch_.frame_ahead(frame_.t, last_.t)) {
    case ClockWatch::Ahead::kPossible:
      break;
    case ClockWatch::Ahead::kImpossible:
      return Turn::kDropFrame;
    case ClockWatch::Ahead::kClockSet:
      clock_was_set();
  }
  return Turn::kWait;
}

// A frame that comes too late to be used, seen from what has been handed out.
bool Door::is_late(const GoodSample* imu, DoorLoss& why) const {
  if (frame_.t <= last_frame_t_) {
    why = DoorLoss::kFrameBackwards;
    return true;
  }
  why = DoorLoss::kFrameBeforeImu;
  return has_last_ ? frame_.t < last_.t : imu != nullptr && frame_.t < imu->sample.t;
}

// Without a frame in sight a sample must wait, or the frame's own sample could not be made; but
// dead reckoning must go on when nobody has seen a frame for a while.
bool Door::imu_may_pass() {
  if (cameras_silent_ || watch_of(Sensor::kCamera).ended()) return true;
  if (!camera_silence_.lasts(frame_wait_) && wants_imu()) return false;
  if (camera_silence_.is_news()) news_.losses.add(DoorLoss::kCameraSilent);
  cameras_silent_ = camera_silence_.lasts(frame_wait_);
  return true;
}

void Door::hand_out_frame(DoorItem& out) {
  image_guard_.check(frame_.images, news_.losses);
  out.kind = DoorItemKind::kFrame;
  out.frame = frame_;
  frame_state_ = FrameState::kLent;
  last_frame_t_ = frame_.t;
  watch_.frame_handed_out(frame_.t);
}

void Door::hand_out_sample(Turn turn, const GoodSample& next, DoorItem& out) {
  const bool cut = turn == Turn::kSampleAtFrame;
  out.kind = DoorItemKind::kImu;
  out.imu = cut ? interpolated(last_, next.sample, frame_.t) : next.sample;
  out.broken = turn == Turn::kBreak;
  if (out.broken) {  // what was before has nothing to say about what comes
    last_frame_t_ = INT64_MIN;
    imu_begin_ = INT64_MIN;
    watch_.restart();
  }
  last_ = out.imu;
  has_last_ = true;
  watch_.handed_out(last_);
  if (!cut) imu_queue_.pop();
}

void Door::drop_frame(DoorLoss why) {
  news_.losses.add(why);
  release();
}

void Door::release() {
  PIRVS_ASSERT(frame_state_ != FrameState::kNone);
  frame_state_ = FrameState::kNone;
  if (listener_.release != nullptr) listener_.release(listener_.context, frame_.images);
}

ClockVerdict Door::judge_clocks(const ClockCheck::Frame& frame) {
  const ClockVerdict verdict = watch_.judge(frame);
  if (verdict != ClockVerdict::kRight) clock_was_set();
  return verdict;
}

void Door::clock_was_set() {
  watch_.accept_step(news_.losses);
  frame_.t = watch_.to_imu_clock(frame_.images.t);
  last_frame_t_ = INT64_MIN;
}

}  // namespace pirvs
