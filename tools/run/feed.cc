#include "tools/run/feed.h"

#include <utility>

namespace pirvs::tools {

Feed::Feed(const Recording& recording, const std::vector<Fault>& faults,
           std::function<void(size_t played)> on_frame, TimeNs camera_latency)
    : recording_(recording),
      faults_(faults, recording),
      player_(recording),
      on_frame_(std::move(on_frame)),
      camera_delay_(recording.calibration.camera_time_offset_ns + camera_latency),
      follows_order_(!recording.order.empty() && faults.empty() && camera_latency == 0),
      tells_fixes_(!recording.gnss.empty() && (!follows_order_ || recording.gnss_apart)),
      tells_wheels_(!recording.wheels.empty() && (!follows_order_ || recording.wheels_apart)) {}

bsp::RecordingSource Feed::source() {
  bsp::RecordingSource out = {this, next_imu, next_frame, release_frame, arrival};
  if (follows_order_) {
    out.order = order;
    out.go_on = go_on;
  }
  return out;
}

bool Feed::next_imu(void* context, ImuSample& out) {
  Feed& feed = *static_cast<Feed*>(context);
  while (!feed.ended() && feed.imu_at_ < feed.recording_.imu.size()) {
    out = feed.recording_.imu[feed.imu_at_++];
    feed.imu_arrival_ = out.t;
    if (feed.faults_.pass(out)) return true;
  }
  return false;
}

bool Feed::next_frame(void* context, StereoFrame& out) {
  Feed& feed = *static_cast<Feed*>(context);
  const FrameId id = out.id;
  while (const StereoFrame* const frame = feed.ended() ? nullptr : feed.player_.next()) {
    if (feed.on_frame_) feed.on_frame_(feed.player_.frames_played());
    out = *frame;
    out.id = id;
    feed.lent_[id.slot] = frame;
    feed.frame_arrival_ = out.t + feed.camera_delay_;
    if (feed.faults_.pass(out)) return true;
    feed.player_.release(frame);
  }
  return false;
}

TimeNs Feed::arrival(void* context, bool frame) {
  const Feed& feed = *static_cast<Feed*>(context);
  return frame ? feed.frame_arrival_ : feed.imu_arrival_;
}

bool Feed::order(void* context, bsp::RecordedArrival& out) {
  using Kind = bsp::RecordedArrival::Kind;
  Feed& feed = *static_cast<Feed*>(context);
  const std::vector<OrderRow>& rows = feed.recording_.order;
  if (feed.ended() || feed.order_at_ == rows.size()) return false;
  const OrderRow& row = rows[feed.order_at_];
  const Kind sensor = row.sensor == Sensor::kImu ? Kind::kImu : Kind::kFrame;
  switch (row.kind) {
    case ArrivalKind::kImu:
      out = {Kind::kImu, row.after_loss ? Status::kFull : Status::kOk, 0};
      break;
    case ArrivalKind::kFrame:
      out = {Kind::kFrame, Status::kOk, 0};
      break;
    case ArrivalKind::kTick:
      out = {Kind::kTick, Status::kOk, row.t};
      break;
    case ArrivalKind::kFault:
      out = {sensor, row.status, 0};
      break;
    case ArrivalKind::kEnd:
      out = {sensor, Status::kStale, 0};
      break;
    default:  // told, not asked for
      out = {Kind::kOther, Status::kOk, 0};
  }
  return true;
}

bool Feed::next_told(void* context, Arrival& out) {
  Feed& feed = *static_cast<Feed*>(context);
  if (next_other_told(context, out)) return true;
  bsp::RecordedArrival next;
  if (!feed.follows_order_ || !order(context, next)) return false;
  if (next.kind != bsp::RecordedArrival::Kind::kOther) return false;
  out = pirvs::arrival_of(feed.recording_.order[feed.order_at_++]);
  return true;
}

bool Feed::next_other_told(void* context, Arrival& out) {
  Feed& feed = *static_cast<Feed*>(context);
  return feed.next_fix_told(out) || feed.next_wheel_told(out);
}

// A fix comes once the IMU has come to its time, and as much later as the receiver takes.
bool Feed::next_fix_told(Arrival& out) {
  if (!tells_fixes_ || fix_at_ == recording_.gnss.size()) return false;
  const GnssFix& fix = recording_.gnss[fix_at_];
  const TimeNs comes =
      fix.t + recording_.calibration.gnss.time_offset_ns + recording_.gnss_sensor.latency_ns;
  if (imu_arrival_ < comes) return false;
  ++fix_at_;
  out = pirvs::arrival_of(fix);
  return true;
}

bool Feed::next_wheel_told(Arrival& out) {
  if (!tells_wheels_ || wheel_at_ == recording_.wheels.size()) return false;
  const WheelSample& wheel = recording_.wheels[wheel_at_];
  if (imu_arrival_ < wheel.t + recording_.calibration.wheels.time_offset_ns) return false;
  ++wheel_at_;
  out = pirvs::arrival_of(wheel);
  return true;
}

bool Feed::next_map(void* context, uint32_t& keyframe) {
  Feed& feed = *static_cast<Feed*>(context);
  const std::vector<uint32_t>& maps = feed.recording_.maps;
  if (!feed.follows_order_ || feed.map_at_ == maps.size()) return false;
  keyframe = maps[feed.map_at_++];
  return true;
}

void Feed::release_frame(void* context, FrameId id) {
  Feed& feed = *static_cast<Feed*>(context);
  feed.player_.release(feed.lent_[id.slot]);
}

}  // namespace pirvs::tools
