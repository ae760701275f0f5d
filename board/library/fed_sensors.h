// The sensors of this board: what a program feeds. bsp/api/camera.h, imu.h and tick.h mean them.
// In      open_fed_sensors(): before anything is fed or polled; the images' size, and whether time
//         passes by the clock. add(): in order of time; samples from one thread, images from one.
//         Images are copied.
// Out     What bsp/api says. end_fed_sensors(): once all that was added has been polled, the
//         streams have ended.
// Errors  add: kFull, kImuWaiting samples or kFramesWaiting frames wait: nothing was taken. The
//         next one that is tells that some were lost before it.
// Cost    A copy of the images. Memory: 26 MB of pixels, of which images use their size.
// Source  bsp/replay/sensors.h: that of a recording.
#pragma once

#include <cstdint>

#include "bsp/api/camera.h"
#include "bsp/api/imu.h"

namespace pirvs::board {

inline constexpr int kImuWaiting = 512;  // 2.5 s at 200 Hz
inline constexpr int kFramesWaiting = 2;

struct FedImages {
  TimeNs t = 0;
  const uint8_t* image[kCamerasMax] = {};  // nullptr: it is missing
  int stride = 0;
};

void open_fed_sensors(int width, int height, bool by_the_clock);
Status add(const ImuSample& sample);
Status add(const FedImages& images);
void end_fed_sensors();

}  // namespace pirvs::board
