// A PC whose sensors are a recording or a simulation (bsp/linux, bsp/replay).
// Errors  none; the asserts below keep the board within bsp/api/cores.h and its cores in time.
#pragma once

#include "bsp/api/cores.h"
#include "bsp/drivers/icm20602/icm20602.h"
#include "modules/app/app.h"

namespace pirvs::board {

// Which core runs what, by the number of cores. Tracking and the sensor door share the first, since
// each waits for the other's result.
inline constexpr int kCores = 3;
inline constexpr CorePlan kPlans[kCores] = {
    // cores door left right tracking mapping, frames a second
    {1, 0, 0, 0, 0, 0, 40},
    {2, 0, 0, 1, 0, 1, 60},
    {3, 0, 0, 1, 0, 2, 60},
};
static_assert(kCores <= bsp::kCoresMax);
static_assert(keep_up(kPlans, bsp::Icm20602::kFifo), "budgets are those of an A72: a PC is faster");

}  // namespace pirvs::board
