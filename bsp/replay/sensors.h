// The sensors of a board that has none of its own: those of a recording. bsp/api/camera.h, imu.h
// and tick.h then mean it.
// In      play(): before the sensors are polled, from the core that polls them.
// Errors  Before the first play() polling is a bug, and there is nothing to call.
// Source  replay.h.
#pragma once

#include "bsp/replay/replay.h"

namespace pirvs::bsp {

void play(const RecordingSource& source, ReplayPace pace);
// now() on the clock of the recording's stamps; in real time only, after the first poll.
TimeNs replay_now();

}  // namespace pirvs::bsp
