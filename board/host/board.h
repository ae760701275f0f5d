// A PC whose sensors are a recording or a simulation (bsp/linux, bsp/replay).
// Errors  none; the assert below keeps the board within bsp/api/cores.h.
#pragma once

#include "bsp/api/cores.h"
#include "modules/app/app.h"

namespace pirvs::board {

// Which core runs what, by the number of cores. Tracking and the sensor door share the first, since
// each waits for the other's result.
inline constexpr int kCores = 3;
inline constexpr CorePlan kPlans[kCores] = {
    // cores door left right tracking mapping
    {1, 0, 0, 0, 0, 0},
    {2, 0, 0, 1, 0, 1},
    {3, 0, 0, 1, 0, 2},
};

static_assert(kCores <= bsp::kCoresMax);

}  // namespace pirvs::board
