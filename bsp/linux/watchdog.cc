#include "bsp/linux/watchdog.h"

#include <atomic>

#include "bsp/api/clock.h"
#include "bsp/api/cores.h"
#include "bsp/api/watchdog.h"

namespace pirvs::bsp {
namespace {

struct Kick {
  std::atomic<const char*> task{nullptr};  // nullptr: the core rests, or has ended
  std::atomic<TimeNs> t{0};
};
Kick kicks[kCoresMax];

// Of this thread; its end must take no memory, so it is given back by hand.
thread_local Kick* own = nullptr;

Kick* claim() {
  for (Kick& kick : kicks) {
    TimeNs free = 0;
    if (kick.t.compare_exchange_strong(free, now())) return &kick;
  }
  return nullptr;
}

}  // namespace

void watchdog_kick(const char* task) {
  if (own == nullptr) own = claim();
  if (own == nullptr) return;  // more threads than cores: nobody watches them
  own->t.store(now(), std::memory_order_relaxed);
  own->task.store(task, std::memory_order_release);
}

void watchdog_forget() {
  if (own == nullptr) return;
  own->task.store(nullptr);
  own->t.store(0);
  own = nullptr;
}

const char* stuck_task(TimeNs longest_ns) {
  for (const Kick& kick : kicks) {
    const char* const task = kick.task.load(std::memory_order_acquire);
    if (task != nullptr && now() - kick.t.load(std::memory_order_relaxed) > longest_ns) return task;
  }
  return nullptr;
}

}  // namespace pirvs::bsp
