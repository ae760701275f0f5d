// Plays a recording as the camera and the IMU of bsp/api, which sensors.h then answers for.
// In      A RecordingSource: each call gives the next item of a stream in the order recorded;
//         false: the stream has ended. next_frame finds in out.id the slot that the frame will be
//         lent under, one of kReplayFrames; release_frame comes once for each frame, from the core
//         of its last holder, before that slot is used again. The source decodes; nothing here
//         does.
// Out     poll, poll_tick: as camera_poll, imu_poll and tick_poll, all from one core; retain,
//         release: as camera_retain and camera_release, from any core. Items come in the order of
//         their arrival; ask for the frame first, as a driver's buffer it keeps what is not asked
//         for.
//         kFast: the next sample is there whenever it is asked for, a frame once all samples that
//         came before it have been given. kRealTime: an item appears when as much of now() has
//         passed since the first poll as lies between its arrival and the earliest one; kEmpty
//         until then, and bsp::alarm ends the core's wait in time. Stamps stay the recording's own.
// Errors  kStale: the stream has ended. kEmpty: bsp::kFramesLentMax frames are held; a replay
//         loses none.
// Cost    That of the source; no copy of pixels.
// Source  docs/architecture.md: board/host runs on recorded sensors.
#pragma once

#include <cstdint>

#include "bsp/api/camera.h"
#include "bsp/api/imu.h"
#include "core/store/lending.h"

namespace pirvs::bsp {

enum class ReplayPace : uint8_t { kFast, kRealTime };

// One row of the order in which everything came when a recording was made.
struct RecordedArrival {
  enum class Kind : uint8_t { kImu, kFrame, kTick, kOther };
  Kind kind = Kind::kOther;     // kOther: not asked for; whoever takes it goes past it
  Status status = Status::kOk;  // kImu, kFrame: what the poll answers; the item belongs to kOk
  TimeNs t = 0;                 // kTick
};

inline constexpr int kReplayFrames = kFramesLentMax + 1;  // one is fetched before it is due

struct RecordingSource {
  void* context;
  bool (*next_imu)(void* context, ImuSample& out);
  bool (*next_frame)(void* context, StereoFrame& out);
  void (*release_frame)(void* context, FrameId id);
  // When the item that next_imu, or next_frame, gave last came, on a clock of the source's own. Not
  // given: at its stamp.
  TimeNs (*arrival)(void* context, bool frame) = nullptr;
  // The row at hand, false at the end; and past it. Given, kFast follows it to the letter: each
  // poll answers as it did then, and kEmpty until its turn has come.
  bool (*order)(void* context, RecordedArrival& out) = nullptr;
  void (*go_on)(void* context) = nullptr;
  // Of cameras that can be told, as camera_range and camera_control; not given: kNotFound.
  Result<CameraRange> (*range)(void* context) = nullptr;
  Status (*control)(void* context, const CameraControl& control) = nullptr;
};

class Replay {
 public:
  // Forgets an earlier recording and its frames, held or not.
  void start(const RecordingSource& source, ReplayPace pace);

  Status poll(ImuSample& out);
  Status poll(StereoFrame& out);
  Status poll_tick(TimeNs& out);
  Result<CameraRange> range() const {
    return source_.range != nullptr ? source_.range(source_.context) : Status::kNotFound;
  }
  Status control(const CameraControl& control) const {
    return source_.control != nullptr ? source_.control(source_.context, control)
                                      : Status::kNotFound;
  }
  // now() on the clock of the recording's stamps; kRealTime only, after the first poll.
  TimeNs sensor_now() const;
  void retain(FrameId id) { lending_.retain(id); }
  void release(FrameId id);

 private:
  // The next item of a stream, fetched before it is due.
  template <class T>
  struct Ahead {
    T item;
    TimeNs arrival = 0;
    bool here = false;
    bool ended = false;

    void take(T& out) {
      out = item;
      here = false;
    }
  };

  void fetch_imu();
  void fetch_frame();
  TimeNs arrival_of(TimeNs stamp, bool is_frame) const;
  void find_offset();
  bool is_due(TimeNs arrival);
  bool follows_order() const { return source_.order != nullptr && pace_ == ReplayPace::kFast; }
  Status next_row(RecordedArrival::Kind kind, RecordedArrival& row) const;

  RecordingSource source_{};
  ReplayPace pace_ = ReplayPace::kFast;
  Ahead<ImuSample> imu_;
  Ahead<StereoFrame> frame_;
  Lending<StereoFrame, kReplayFrames> lending_;
  bool offset_known_ = false;
  TimeNs offset_ = 0;  // now() minus sensor time
  TimeNs next_tick_ = 0;
};

}  // namespace pirvs::bsp
