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
  bool here = false;
  bool ended = false;

  void fetch(bool (*next)(void*, T&), void* context) {
    if (here || ended) return;
    here = next(context, item);
    ended = !here;
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

  bool is_due(TimeNs t) {
    if (pace == ReplayPace::kFast) return true;
    if (!started) start();
    return now() >= t + offset;
  }

  void start() {
    imu.fetch(source.next_imu, source.context);
    frame.fetch(source.next_frame, source.context);
    const TimeNs imu_t = imu.here ? imu.item.t : INT64_MAX;
    const TimeNs frame_t = frame.here ? frame.item.t : INT64_MAX;
    offset = now() - std::min(imu_t, frame_t);
    started = true;
  }

  template <class T>
  Status poll(Ahead<T>& ahead, bool (*next)(void*, T&), T& out) {
    ahead.fetch(next, source.context);
    if (ahead.ended) return Status::kStale;
    if (!is_due(ahead.item.t)) return Status::kEmpty;
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

Status imu_poll(ImuSample& out) { return replay.poll(replay.imu, replay.source.next_imu, out); }

Status camera_poll(StereoFrame& out) {
  PIRVS_ASSERT(!replay.frame_lent);
  const Status status = replay.poll(replay.frame, replay.source.next_frame, out);
  replay.frame_lent = status == Status::kOk;
  return status;
}

Status tick_poll(TimeNs& out) {
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
