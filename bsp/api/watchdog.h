// Tells the machine that a core still comes round its schedule, and what it is about to do.
// In      The name of the task that begins, a literal; nullptr when the core rests.
// Out     Bare metal: a core that begins or rests nothing for kWatchdog_ns ends in a fault report
//         with that name, and a restart. Linux: bsp/linux/watchdog.h tells which task hangs.
// Errors  none.
// Cost    One clock reading and two stores.
// Source  STYLE principle 2: a step runs to completion and is small.
#pragma once

#include "core/base/time.h"

namespace pirvs::bsp {

// 60 times the longest budget of a task's step, and short for a robot in flight.
inline constexpr TimeNs kWatchdog_ns = 1'000'000'000;

void watchdog_kick(const char* task);

}  // namespace pirvs::bsp
