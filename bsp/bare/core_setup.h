// What every core does before it runs C++ of the application: interrupts, watchdog, counters.
// In      The core's own number (registers.h).
// Out     start_this_core: interrupts are taken from here on.
// Errors  A core without its redistributor is a bug of the board's constants and asserts.
// Cost    ~10 us.
// Source  bsp/bare.
#pragma once

namespace pirvs::bsp {

void start_this_core();

void cycles_start_core();
void watchdog_start();       // once, on core 0
void watchdog_start_core();  // on each core
// What this core has begun last: a task's name, or nullptr.
const char* watchdog_task(int core);

}  // namespace pirvs::bsp
