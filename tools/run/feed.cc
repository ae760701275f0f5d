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
      tells_fixes_(!recording.gnss.empty() && (!follows_order_ || recording.gnss_apart)) {}

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
  while (feed.imu_at_ < feed.recording_.imu.size()) {
    out = feed.recording_.imu[feed.imu_at_++];
    feed.imu_arrival_ = out.t;
    if (feed.faults_.pass(out)) return true;
  }
  return false;
}

bool Feed::next_frame(void* context, StereoFrame& out) {
  Feed& feed = *static_cast<Feed*>(context);
  const FrameId id = out.id;
  while (const StereoFrame* const frame = feed.player_.next()) {
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
  if (feed.order_at_ == rows.size()) return false;
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
  if (feed.tells_fixes_ && next_fix_told(context, out)) return true;
  bsp::RecordedArrival next;
  if (!feed.follows_order_ || !order(context, next)) return false;
  if (next.kind != bsp::RecordedArrival::Kind::kOther) return false;
  out = pirvs::arrival_of(feed.recording_.order[feed.order_at_++]);
  return true;
}

// A fix comes once the IMU has come to its time, and as much later as the receiver takes.
bool Feed::next_fix_told(void* context, Arrival& out) {
  Feed& feed = *static_cast<Feed*>(context);
  const Recording& recording = feed.recording_;
  if (feed.fix_at_ == recording.gnss.size()) return false;
  const GnssFix& fix = recording.gnss[feed.fix_at_];
  const TimeNs comes =
      fix.t + recording.calibration.gnss.time_offset_ns + recording.gnss_sensor.latency_ns;
  if (feed.imu_arrival_ < comes) return false;
  ++feed.fix_at_;
  out = pirvs::arrival_of(fix);
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
