// Plays a recording as the camera and the IMU of bsp/api.
// In      A RecordingSource: each call gives the next item of a stream in the order recorded;
//         false: the stream has ended. One frame is lent at a time: the next is asked for only
//         after release_frame. The source decodes; nothing here does.
// Out     camera_poll, imu_poll, tick_poll: all from the core that called replay_start. Items come
//         in the order of their arrival; ask for the frame first, as a driver's buffer it keeps what
//         is not asked for.
//         kFast: the next sample is there whenever it is asked for, a frame once all samples that
//         came before it have been given. kRealTime: an item appears when as much of now() has
//         passed since the first poll as lies between its arrival and the earliest one; kEmpty
//         until then. Stamps stay the recording's own.
// Frames  as the source has them.
// Errors  kStale: the stream has ended. Polling a frame while one is lent is a bug and asserts.
// Cost    That of the source; no copy of pixels.
// Source  DESIGN, "Folders": board/host runs on recorded sensors.
#pragma once

#include <cstdint>

#include "bsp/api/camera.h"
#include "bsp/api/imu.h"

namespace pirvs::bsp {

enum class ReplayPace : uint8_t { kFast, kRealTime };

// One row of the order in which everything came when a recording was made.
struct RecordedArrival {
  enum class Kind : uint8_t { kImu, kFrame, kTick, kOther };
  Kind kind = Kind::kOther;     // kOther: not of a sensor; whoever takes it goes past it
  Status status = Status::kOk;  // kImu, kFrame: what the poll answers; the item belongs to kOk
  TimeNs t = 0;                 // kTick
};

struct RecordingSource {
  void* context;
  bool (*next_imu)(void* context, ImuSample& out);
  bool (*next_frame)(void* context, StereoFrame& out);
  void (*release_frame)(void* context);
  // When the item that next_imu, or next_frame, gave last came, on a clock of the source's own. Not
  // given: at its stamp.
  TimeNs (*arrival)(void* context, bool frame) = nullptr;
  // The row at hand, false at the end; and past it. Given, kFast follows it to the letter: each
  // poll answers as it did then, and kEmpty until its turn has come.
  bool (*order)(void* context, RecordedArrival& out) = nullptr;
  void (*go_on)(void* context) = nullptr;
};

void replay_start(const RecordingSource& source, ReplayPace pace);

}  // namespace pirvs::bsp
