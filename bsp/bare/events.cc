#include "bsp/api/events.h"

#include <algorithm>
#include <atomic>

#include "bsp/api/clock.h"
#include "bsp/api/cores.h"
#include "bsp/api/watchdog.h"
#include "bsp/bare/registers.h"
#include "core/base/assert.h"

namespace pirvs::bsp {
namespace {

struct Core {
  std::atomic<bool> woken{false};
  TimeNs next_alarm = INT64_MAX;
};
Core cores[kCoresMax];

}  // namespace

// An interrupt, an SEV of another core and the event stream (bsp/bare/cores.cc) all end a WFE, also
// one that has not begun yet; so `until` is met to within 11 us.
void wait(int core, TimeNs until) {
  PIRVS_ASSERT(core == this_core());
  Core& self = cores[core];
  until = std::min(until, self.next_alarm);
  self.next_alarm = INT64_MAX;
  watchdog_kick(nullptr);
  while (!self.woken.exchange(false, std::memory_order_acq_rel) && now() < until) {
    asm volatile("wfe" ::: "memory");
  }
}

void wake(int core) {
  PIRVS_ASSERT(core >= 0 && core < kCoresMax);
  cores[core].woken.store(true, std::memory_order_release);
  asm volatile("dsb ish\n sev" ::: "memory");
}

void alarm(TimeNs t) {
  Core& self = cores[this_core()];
  self.next_alarm = std::min(self.next_alarm, t);
}

}  // namespace pirvs::bsp
