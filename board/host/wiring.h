// Which sensors a PC has: those of a recording. bsp/api/camera.h and imu.h answer for them.
// In      play(): before the sensors are polled, from the core that polls them.
// Errors  Before the first play() polling is a bug, and there is nothing to call.
// Source  bsp/replay/replay.h.
#pragma once

#include "bsp/replay/replay.h"

namespace pirvs::board {

void play(const bsp::RecordingSource& source, bsp::ReplayPace pace);
// now() on the clock of the recording's stamps; in real time only, after the first poll.
TimeNs replay_now();

}  // namespace pirvs::board
