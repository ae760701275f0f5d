// A PC whose sensors are a recording or a simulation (bsp/linux, bsp/replay).
// Errors  none; the asserts below keep the board within core/base/limits.h and bsp/api/cores.h.
// Source  DESIGN, "Folders"; EuRoC's sensors, the largest that are replayed.
#pragma once

#include "bsp/api/cores.h"
#include "core/base/limits.h"
#include "modules/app/app.h"

namespace pirvs::board {

inline constexpr int kImageWidth = 752;
inline constexpr int kImageHeight = 480;
inline constexpr int kCameras = 2;

// Which core runs what, by the number of cores. Tracking and the sensor door share the first, since
// each waits for the other's result.
inline constexpr int kCores = 3;
inline constexpr CorePlan kPlans[kCores] = {
    // cores door left right tracking mapping
    {1, 0, 0, 0, 0, 0},
    {2, 0, 0, 1, 0, 1},
    {3, 0, 0, 1, 0, 2},
};

static_assert(kImageWidth <= kImageWidthMax && kImageHeight <= kImageHeightMax);
static_assert(kCameras <= kCamerasMax);
static_assert(kCores <= bsp::kCoresMax);

}  // namespace pirvs::board
