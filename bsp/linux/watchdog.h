// Which task hangs: what bsp/api/watchdog.h has been told, looked at from any core.
// In      watchdog_forget(): at the end of a thread that has kicked.
// Out     stuck_task(): a task whose step has lasted longer than that, by its name; nullptr: none.
// Errors  none. A core that is starved by others counts as hanging, too.
// Cost    A look at kCoresMax times.
// Source  board/linux/watchdog.h, which tells the machine.
#pragma once

#include "core/base/time.h"

namespace pirvs::bsp {

const char* stuck_task(TimeNs longest_ns);
void watchdog_forget();

}  // namespace pirvs::bsp
