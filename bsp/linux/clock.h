// Sleep on the clock of bsp/api/clock.h, for threads of drivers that are no cores of a schedule.
// Out     Returns at the time, or at once if it is past; signals do not end it.
// Errors  none.
// Cost    One system call; the kernel wakes a thread some 10 to 100 us late.
// Source  clock_nanosleep(2).
#pragma once

#include "core/base/time.h"

namespace pirvs::bsp {

void sleep_until(TimeNs t);

}  // namespace pirvs::bsp
