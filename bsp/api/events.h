// Waiting for work without polling: until another core or a device has some, or until a time.
// In      wait: the calling core's own number, and a time on the clock of now(). wake: from any
//         core, and from an interrupt handler; the core need not be waiting. alarm: the time at
//         which an event of this core is due, known beforehand; for backends alone.
// Out     wait returns at `until`, or at an earlier alarm of this core, or when wake(core) has been
//         called since the last wait of this core returned, or when a device of this core has
//         something (Linux: a file descriptor, bsp/linux/events.h); now and then for no reason.
//         A wake that comes between a look around and the wait that follows it is not lost. Each
//         wait uses up the alarms set before it.
// Errors  none. `until` in the past: returns at once.
// Cost    wake: ~10 ns when the core is awake; Linux: one system call when it sleeps, and ~50 us
//         until it runs.
// Source  Linux: poll, eventfd. Bare metal: WFE, SEV, and the event stream of the timer.
#pragma once

#include "core/base/time.h"

namespace pirvs::bsp {

void wait(int core, TimeNs until);
void wake(int core);
void alarm(TimeNs t);

}  // namespace pirvs::bsp
