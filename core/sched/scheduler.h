// Cooperative scheduler: after each step the first row of the table that has work runs.
// In      A table of tasks in order of priority; the machine's clock, and how its cores wait for
//         each other; stop() from any core or step.
// Out     Steps run to completion on the core of their row; counters per task.
//         run(core): the rows of one core until stop(), which is for good. Work runs at once: a row
//         is asked whenever no row above it has work. When none of its rows has work the core
//         waits, for a device, or for a row of another core that names one of its rows in `wakes`,
//         and never longer than kRest_ns: not all that a step looks at wakes.
//         run_until_idle(): all rows in lockstep until every step says kIdle. The order depends on
//         the table and the steps alone, not on a clock.
//         poll, poll_lockstep: one step of either, for a caller with other things to do.
// Units   ns: the step's `now` is the clock's.
// Errors  Never silent, counted per task: overrun, a step took longer than its budget by the clock
//         (preemption counts: the rows above had to wait); slip, the core came to ask a row later
//         than its work may come, though it had not rested.
// Cost    Two readings of the clock per step, 60 ns on x86-64 Linux; no heap. A core at rest wakes
//         40 times a second.
// Source  STYLE principles 1 and 2; ArduPilot AP_Scheduler.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/assert.h"
#include "core/base/counter.h"
#include "core/base/time.h"

namespace pirvs {

enum class Step : uint8_t {
  kIdle,   // nothing was done: no input, or the job is finished
  kAgain,  // something was done: ask every row again, from the first
};

// The first four say when and where, constants of the design; the last two what.
struct Task {
  const char* name;
  uint32_t every_us;   // its work comes no more often; 0: background, takes the time that is left
  uint32_t budget_us;  // of one step
  uint8_t core;
  uint32_t wakes = 0;  // rows, by bit, that may have work after a step that said kAgain
  Step (*step)(void* context, TimeNs now) = nullptr;
  void* context = nullptr;
};

inline constexpr int kAllCores = -1;

constexpr bool runs_on(const Task& task, int core) {
  return core == kAllCores || task.core == core;
}

// Share of a core that its rows need when work comes as often as it may and each step uses its
// whole budget. Background is left out.
template <class Tasks>
constexpr double utilisation(const Tasks& tasks, int core = kAllCores) {
  double sum = 0.0;
  for (const Task& task : tasks) {
    if (runs_on(task, core) && task.every_us > 0) {
      sum += static_cast<double>(task.budget_us) / task.every_us;
    }
  }
  return sum;
}

// How long the first row may have to wait.
template <class Tasks>
constexpr uint32_t longest_budget_us(const Tasks& tasks, int core = kAllCores) {
  uint32_t longest = 0;
  for (const Task& task : tasks) {
    if (runs_on(task, core) && task.budget_us > longest) longest = task.budget_us;
  }
  return longest;
}

// A core without work looks around again after this long at the latest.
inline constexpr TimeNs kRest_ns = 25'000'000;

// What the schedule needs of the machine.
struct SchedulerHooks {
  TimeNs (*now)();
  void (*wait)(int core, TimeNs until);  // returns early after wake(core)
  void (*wake)(int core);                // from any core; not lost when it comes before the wait
  // Called with the task's name before each step, with nullptr when the core leaves the schedule.
  void (*alive)(const char* task) = nullptr;
};

struct TaskCounters {
  Counter runs, overruns, slips;
  BasicCounter<TimeNs> busy_total, busy_max;
};

class Scheduler {
 public:
  static constexpr size_t kTasksMax = 16;

  // The table must outlive the scheduler.
  template <size_t N>
  Scheduler(const Task (&tasks)[N], const SchedulerHooks& hooks)
      : tasks_(tasks), count_(N), hooks_(hooks) {
    static_assert(N <= kTasksMax);
  }

  void run(int core);
  void run_until_idle();
  bool poll(int core);   // one step or one rest; false: stopped
  bool poll_lockstep();  // one step; false: stopped, or every step has said kIdle
  bool stopped() const { return stopped_.load(std::memory_order_relaxed); }
  void stop();  // from any core or step

  size_t size() const { return count_; }
  const Task& task(size_t i) const {
    PIRVS_ASSERT(i < count_);
    return tasks_[i];
  }
  const TaskCounters& counters(size_t i) const {  // from any core
    PIRVS_ASSERT(i < count_);
    return states_[i].counters;
  }

 private:
  // Written by the core that runs the row. Others read the counters.
  struct State {
    bool idle = false;         // said kIdle, and nothing has happened on its core since
    TimeNs asked = INT64_MAX;  // when the core last came to this row; INT64_MAX: it has rested
    TaskCounters counters;
  };

  bool run_first_due(int core);
  void count_slips(size_t i, TimeNs now);
  Step execute(size_t i, TimeNs begin);
  void wake_others(size_t i);
  void forget_idle(int core);
  void forget_asked(int core);
  void say_alive(const char* task) {
    if (hooks_.alive != nullptr) hooks_.alive(task);
  }

  const Task* tasks_;
  size_t count_;
  SchedulerHooks hooks_;
  State states_[kTasksMax];
  std::atomic<bool> stopped_{false};
};

}  // namespace pirvs
