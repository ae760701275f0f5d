// Says which tasks have repeatedly been late: over their budget, or asked too late.
// In      A scheduler's counters and the time, whenever it suits the caller.
// Out     next(): one late task after the other; each at most once in kLateWindow_ns, and only if
//         it was late kLateTimes or more since it was last looked at. Less is noise, and stays a
//         counter.
// Errors  none.
// Cost    A few loads a task. From one core.
// Source  F' ActiveRateGroup: a slipped cycle is an event.
#pragma once

#include "core/sched/scheduler.h"

namespace pirvs {

inline constexpr TimeNs kLateWindow_ns = 1'000'000'000;
inline constexpr uint32_t kLateTimes = 3;

struct LateTask {
  const char* name = "";
  uint32_t overruns = 0, slips = 0;  // since it was last looked at
  TimeNs longest = 0;                // step since the start
};

class LateWatch {
 public:
  // False: none is left to tell.
  bool next(const Scheduler& scheduler, TimeNs now, LateTask& out) {
    for (size_t i = 0; i < scheduler.size(); ++i) {
      if (now < looked_[i].again_at) continue;
      const TaskCounters& counters = scheduler.counters(i);
      const Look before = looked_[i];
      looked_[i] = {now + kLateWindow_ns, counters.overruns, counters.slips};
      out = {scheduler.task(i).name, looked_[i].overruns - before.overruns,
             looked_[i].slips - before.slips, counters.busy_max};
      if (out.overruns + out.slips >= kLateTimes) return true;
    }
    return false;
  }

 private:
  struct Look {
    TimeNs again_at = INT64_MIN;
    uint32_t overruns = 0, slips = 0;
  };
  Look looked_[Scheduler::kTasksMax];
};

}  // namespace pirvs
