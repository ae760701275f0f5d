#include "bsp/replay/replay.h"

#include <algorithm>
#include <cstdint>

#include "bsp/api/clock.h"
#include "bsp/api/tick.h"
#include "core/base/assert.h"

namespace pirvs::bsp {
namespace {

// The next item of a stream, fetched before it is due.
template <class T>
struct Ahead {
  T item;
  TimeNs arrival = 0;
  bool here = false;
  bool ended = false;

  void fetch(bool (*next)(void*, T&), const RecordingSource& source, bool is_frame) {
    if (here || ended) return;
    here = next(source.context, item);
    ended = !here;
    if (ended) return;
    arrival = source.arrival != nullptr ? source.arrival(source.context, is_frame) : item.t;
  }
};

struct Replay {
  RecordingSource source{};
  ReplayPace pace = ReplayPace::kFast;
  Ahead<ImuSample> imu;
  Ahead<StereoFrame> frame;
  bool frame_lent = false;
  bool started = false;
  TimeNs offset = 0;  // now() minus sensor time
  TimeNs next_tick = 0;

  void fetch_imu() { imu.fetch(source.next_imu, source, false); }
  void fetch_frame() { frame.fetch(source.next_frame, source, true); }

  bool is_due(TimeNs arrival) {
    if (!started) start();
    return now() >= arrival + offset;
  }

  void start() {
    fetch_imu();
    fetch_frame();
    const TimeNs imu_t = imu.here ? imu.arrival : INT64_MAX;
    const TimeNs frame_t = frame.here ? frame.arrival : INT64_MAX;
    offset = now() - std::min(imu_t, frame_t);
    started = true;
  }

  bool follows_order() const { return source.order != nullptr && pace == ReplayPace::kFast; }

  // What the poll of a source answers when a recorded order is followed; kOk: its item is next.
  Status follow(RecordedArrival::Kind kind, RecordedArrival& row) {
    if (!source.order(source.context, row)) return Status::kStale;
    if (row.kind != kind) return Status::kEmpty;
    source.go_on(source.context);
    return row.status;
  }

  template <class T>
  static Status take(Ahead<T>& ahead, T& out) {
    out = ahead.item;
    ahead.here = false;
    return Status::kOk;
  }
};

Replay replay;

}  // namespace

void replay_start(const RecordingSource& source, ReplayPace pace) {
  replay = Replay{};
  replay.source = source;
  replay.pace = pace;
}

Status imu_poll(ImuSample& out) {
  if (replay.follows_order()) {
    RecordedArrival row;
    const Status status = replay.follow(RecordedArrival::Kind::kImu, row);
    if (status != Status::kOk && status != Status::kFull) return status;
    replay.fetch_imu();
    if (replay.imu.ended) return Status::kStale;
    (void)Replay::take(replay.imu, out);
    return status;
  }
  replay.fetch_imu();
  if (replay.imu.ended) return Status::kStale;
  const bool due = replay.pace == ReplayPace::kFast || replay.is_due(replay.imu.arrival);
  return due ? Replay::take(replay.imu, out) : Status::kEmpty;
}

Status camera_poll(StereoFrame& out) {
  PIRVS_ASSERT(!replay.frame_lent);
  if (replay.follows_order()) {
    RecordedArrival row;
    PIRVS_TRY(replay.follow(RecordedArrival::Kind::kFrame, row));
    replay.fetch_frame();
    if (replay.frame.ended) return Status::kStale;
    replay.frame_lent = true;
    return Replay::take(replay.frame, out);
  }
  replay.fetch_frame();
  if (replay.frame.ended) return Status::kStale;
  bool due = false;
  if (replay.pace == ReplayPace::kFast) {
    replay.fetch_imu();
    due = replay.imu.ended || replay.frame.arrival < replay.imu.arrival;
  } else {
    due = replay.is_due(replay.frame.arrival);
  }
  if (!due) return Status::kEmpty;
  replay.frame_lent = true;
  return Replay::take(replay.frame, out);
}

Status tick_poll(TimeNs& out) {
  if (replay.follows_order()) {
    RecordedArrival row;
    const Status status = replay.follow(RecordedArrival::Kind::kTick, row);
    out = row.t;
    return status;
  }
  if (replay.pace == ReplayPace::kFast || now() < replay.next_tick) return Status::kEmpty;
  out = now();
  replay.next_tick = out + kTick_ns;
  return Status::kOk;
}

void camera_release() {
  PIRVS_ASSERT(replay.frame_lent);
  replay.frame_lent = false;
  replay.source.release_frame(replay.source.context);
}

}  // namespace pirvs::bsp
