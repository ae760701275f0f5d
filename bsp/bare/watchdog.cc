#include "bsp/api/watchdog.h"

#include <atomic>

#include "bsp/api/clock.h"
#include "bsp/bare/core_setup.h"
#include "bsp/bare/fault.h"
#include "bsp/bare/interrupts.h"
#include "bsp/bare/machine.h"
#include "bsp/bare/registers.h"
#include "core/base/assert.h"
#include "core/base/text.h"

namespace pirvs::bsp {
namespace {

constexpr uint32_t kVirtualTimer = 27;  // the interrupt of CNTV, on every core
constexpr uint64_t kLooksPerSecond = 10;

struct Watch {
  std::atomic<const char*> task{nullptr};  // nullptr: at rest, nothing to watch
  std::atomic<TimeNs> since{0};
};
Watch watches[kCoresMax];

void set_timer() { PIRVS_WRITE(cntv_tval_el0, PIRVS_READ(cntfrq_el0) / kLooksPerSecond); }

// The timer strikes on the very core that hangs, so that the report shows where.
void look(uint32_t, const ExceptionFrame& frame) {
  set_timer();
  const Watch& watch = watches[this_core()];
  const char* const task = watch.task.load(std::memory_order_relaxed);
  const TimeNs late = now() - watch.since.load(std::memory_order_relaxed);
  if (task == nullptr || late < kWatchdog_ns) return;
  Text<96> what;
  what.put("watchdog: task ").put(task).put(" has not returned for ");
  what.fixed(to_seconds(late), 1).put(" s");
  fault(what.c_str(), frame);
}

}  // namespace

void watchdog_kick(const char* task) {
  Watch& watch = watches[this_core()];
  watch.since.store(now(), std::memory_order_relaxed);
  watch.task.store(task, std::memory_order_relaxed);
}

const char* watchdog_task(int core) { return watches[core].task.load(std::memory_order_relaxed); }

void watchdog_start() {
  const Status handled = interrupt_handle(kVirtualTimer, look);
  PIRVS_ASSERT(handled == Status::kOk);
}

void watchdog_start_core() {
  watches[this_core()].task.store(nullptr, std::memory_order_relaxed);
  set_timer();
  PIRVS_WRITE(cntv_ctl_el0, 1);  // ENABLE, not masked
  interrupt_enable(kVirtualTimer);
}

}  // namespace pirvs::bsp
