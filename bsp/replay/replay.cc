#include "bsp/replay/replay.h"

#include <algorithm>
#include <cstdint>
#include <new>

#include "bsp/api/clock.h"
#include "bsp/api/events.h"
#include "bsp/api/tick.h"

namespace pirvs::bsp {

void Replay::start(const RecordingSource& source, ReplayPace pace) {
  this->~Replay();
  new (this) Replay;
  source_ = source;
  pace_ = pace;
}

void Replay::release(FrameId id) {
  if (!lending_.release(id)) return;
  source_.release_frame(source_.context, id);
  lending_.recycle(id);
}

TimeNs Replay::arrival_of(TimeNs stamp, bool is_frame) const {
  return source_.arrival != nullptr ? source_.arrival(source_.context, is_frame) : stamp;
}

void Replay::fetch_imu() {
  if (imu_.here || imu_.ended) return;
  imu_.here = source_.next_imu(source_.context, imu_.item);
  imu_.ended = !imu_.here;
  if (imu_.here) imu_.arrival = arrival_of(imu_.item.t, false);
}

// Neither here nor ended: every slot is held.
void Replay::fetch_frame() {
  if (frame_.here || frame_.ended) return;
  const Result<FrameId> id = lending_.lend();
  if (!id.ok()) return;
  frame_.item = StereoFrame{};
  frame_.item.id = id.value();
  frame_.here = source_.next_frame(source_.context, frame_.item);
  frame_.item.id = id.value();
  frame_.ended = !frame_.here;
  if (frame_.here) frame_.arrival = arrival_of(frame_.item.t, true);
  if (frame_.ended && lending_.release(id.value())) lending_.recycle(id.value());
}

void Replay::find_offset() {
  fetch_imu();
  fetch_frame();
  const TimeNs imu_t = imu_.here ? imu_.arrival : INT64_MAX;
  const TimeNs frame_t = frame_.here ? frame_.arrival : INT64_MAX;
  offset_ = now() - std::min(imu_t, frame_t);
  offset_known_ = true;
}

TimeNs Replay::sensor_now() const { return now() - offset_; }

bool Replay::is_due(TimeNs arrival) {
  if (!offset_known_) find_offset();
  if (now() >= arrival + offset_) return true;
  alarm(arrival + offset_);
  return false;
}

// What the poll of a source answers when a recorded order is followed; kOk, kFull: its item is
// next. The caller goes past the row once it has what the row promises.
Status Replay::next_row(RecordedArrival::Kind kind, RecordedArrival& row) const {
  if (!source_.order(source_.context, row)) return Status::kStale;
  return row.kind == kind ? row.status : Status::kEmpty;
}

Status Replay::poll(ImuSample& out) {
  Status status = Status::kOk;
  if (follows_order()) {
    RecordedArrival row;
    row.kind = RecordedArrival::Kind::kOther;
    status = next_row(RecordedArrival::Kind::kImu, row);
    if (row.kind != RecordedArrival::Kind::kImu) return status;
    source_.go_on(source_.context);
    if (status != Status::kOk && status != Status::kFull) return status;
  }
  fetch_imu();
  if (imu_.ended) return Status::kStale;
  if (pace_ == ReplayPace::kRealTime && !is_due(imu_.arrival)) return Status::kEmpty;
  imu_.take(out);
  return status;
}

Status Replay::poll(StereoFrame& out) {
  if (follows_order()) {
    RecordedArrival row;
    const Status status = next_row(RecordedArrival::Kind::kFrame, row);
    const bool is_next = row.kind == RecordedArrival::Kind::kFrame;
    if (is_next && status == Status::kOk) fetch_frame();
    const bool no_slot = status == Status::kOk && !frame_.here && !frame_.ended;
    if (!is_next || no_slot) return is_next ? Status::kEmpty : status;
    source_.go_on(source_.context);
    if (status != Status::kOk) return status;
    if (frame_.ended) return Status::kStale;
    frame_.take(out);
    return Status::kOk;
  }
  fetch_frame();
  if (frame_.ended) return Status::kStale;
  if (!frame_.here) return Status::kEmpty;
  bool due = false;
  if (pace_ == ReplayPace::kFast) {
    fetch_imu();
    due = imu_.ended || frame_.arrival < imu_.arrival;
  } else {
    due = is_due(frame_.arrival);
  }
  if (!due) return Status::kEmpty;
  frame_.take(out);
  return Status::kOk;
}

Status Replay::poll_tick(TimeNs& out) {
  if (follows_order()) {
    RecordedArrival row;
    const Status status = next_row(RecordedArrival::Kind::kTick, row);
    if (row.kind == RecordedArrival::Kind::kTick) source_.go_on(source_.context);
    out = row.t;
    return status;
  }
  if (pace_ == ReplayPace::kFast || now() < next_tick_) return Status::kEmpty;
  out = now();
  next_tick_ = out + kTick_ns;
  return Status::kOk;
}

}  // namespace pirvs::bsp
