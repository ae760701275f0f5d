// Starts functions on other cores (Linux: threads; bare metal: PSCI).
// In      core 1..kCoresMax-1, an entry and its argument; core 0 is the caller.
// Out     The entry runs there once. join_cores() returns when every started core is done.
// Errors  start_core: kNotFound (no such core), kFull (it runs already), kBusFault (refused).
// Cost    start and join: tens of microseconds. relax(): what to call in a waiting loop; it gives
//         the processor a rest, on Linux of at most about 100 us.
// Source  STYLE principle 3.
#pragma once

#include "core/base/status.h"

namespace pirvs::bsp {

inline constexpr int kCoresMax = 6;  // RK3399: 4 x A53, 2 x A72

Status start_core(int core, void (*entry)(void*), void* argument);
void join_cores();
void relax();

}  // namespace pirvs::bsp
