// The sensors of a board without an operating system: a recording in RAM, until real ones are
// wired. bsp/api/camera.h and imu.h answer for them.
// In      play(): before the sensors are polled, from the core that polls them.
// Source  bsp/replay/replay.h.
#pragma once

#include "bsp/replay/replay.h"

namespace pirvs::board {

void play(const bsp::RecordingSource& source, bsp::ReplayPace pace);

}  // namespace pirvs::board
