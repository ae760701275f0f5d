// Plays a recording as the camera and the IMU of bsp/api.
// In      A RecordingSource: each call gives the next item of a stream in the order recorded;
//         false: the stream has ended. One frame is lent at a time: the next is asked for only
//         after release_frame. The source decodes; nothing here does.
// Out     camera_poll, imu_poll: both from the core that called replay_start.
//         kFast: an item is there whenever it is asked for. kRealTime: it appears when as much of
//         now() has passed since the first poll as lies between its stamp and the recording's
//         earliest first stamp; kEmpty until then. Stamps stay the recording's own.
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

struct RecordingSource {
  void* context;
  bool (*next_imu)(void* context, ImuSample& out);
  bool (*next_frame)(void* context, StereoFrame& out);
  void (*release_frame)(void* context);
};

void replay_start(const RecordingSource& source, ReplayPace pace);

}  // namespace pirvs::bsp
