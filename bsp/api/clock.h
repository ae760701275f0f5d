// Clocks of the machine.
// Out     now(): monotonic, the same clock as every sensor stamp.
//         cpu_time(): CPU time used by this core (Linux: this thread); only differences count.
// Errors  none; a machine without a clock does not start.
// Cost    now() 30 ns; cpu_time() a system call on Linux, up to 1.5 us: once per job, not per item.
// Source  STYLE principle 3: one definition per backend, chosen by linking.
#pragma once

#include "core/base/time.h"

namespace pirvs::bsp {

TimeNs now();
TimeNs cpu_time();

}  // namespace pirvs::bsp
