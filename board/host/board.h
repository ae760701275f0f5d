// A PC whose sensors are a recording or a simulation (bsp/linux, bsp/replay).
// In, Out nothing: constants.
// Frames  none: calibration comes with the recording.
// Errors  none; the asserts below keep the board within core/base/limits.h and bsp/api/cores.h.
// Cost    none.
// Source  DESIGN, "Folders"; EuRoC's sensors, the largest that are replayed.
#pragma once

#include "bsp/api/cores.h"
#include "core/base/limits.h"

namespace pirvs::board {

inline constexpr int kImageWidth = 752;
inline constexpr int kImageHeight = 480;
inline constexpr int kCameras = 2;

// Which core runs what when there are several: left image, right image, mapping. Tracking and the
// sensor door share the first core, since each waits for the other's result.
inline constexpr int kCoreLeft = 0;
inline constexpr int kCoreRight = 1;
inline constexpr int kCoreMapping = 2;
inline constexpr int kCores = 3;

static_assert(kImageWidth <= kImageWidthMax && kImageHeight <= kImageHeightMax);
static_assert(kCameras <= kCamerasMax);
static_assert(kCores <= bsp::kCoresMax);

}  // namespace pirvs::board
