#include "core/sched/scheduler.h"

#include <utility>

namespace pirvs {

void Scheduler::run(int core) {
  while (poll(core)) {
  }
}

bool Scheduler::poll(int core) {
  if (stopped()) {
    say_alive(nullptr);
    return false;
  }
  if (!run_first_due(core)) {
    hooks_.wait(core, hooks_.now() + kRest_ns);
    forget_idle(core);  // another core may have left something
    forget_asked(core);
  }
  return true;
}

void Scheduler::run_until_idle() {
  forget_idle(kAllCores);
  while (poll_lockstep()) {
  }
}

bool Scheduler::poll_lockstep() {
  if (!stopped() && run_first_due(kAllCores)) return true;
  say_alive(nullptr);
  forget_idle(kAllCores);
  forget_asked(kAllCores);
  return false;
}

void Scheduler::stop() {
  stopped_.store(true, std::memory_order_relaxed);
  for (size_t i = 0; i < count_; ++i) hooks_.wake(tasks_[i].core);
}

bool Scheduler::run_first_due(int core) {
  const TimeNs now = hooks_.now();
  for (size_t i = 0; i < count_; ++i) {
    if (!runs_on(tasks_[i], core)) continue;
    count_slips(i, now);
    if (states_[i].idle) continue;
    const Step step = execute(i, now);
    if (step == Step::kAgain) {
      forget_idle(core);
      wake_others(i);
    }
    states_[i].idle = step == Step::kIdle;
    return true;
  }
  return false;
}

void Scheduler::count_slips(size_t i, TimeNs now) {
  State& state = states_[i];
  const TimeNs every = static_cast<TimeNs>(tasks_[i].every_us) * 1000;
  const TimeNs asked = std::exchange(state.asked, now);
  if (every > 0 && now - asked > every) ++state.counters.slips;
}

// Release, in the hook: what the step wrote is visible to the steps that it leaves work for.
void Scheduler::wake_others(size_t i) {
  for (size_t other = 0; other < count_; ++other) {
    const bool has_work = (tasks_[i].wakes >> other & 1) != 0;
    if (has_work && tasks_[other].core != tasks_[i].core) hooks_.wake(tasks_[other].core);
  }
}

Step Scheduler::execute(size_t i, TimeNs begin) {
  const Task& task = tasks_[i];
  TaskCounters& counters = states_[i].counters;
  say_alive(task.name);
  const Step step = task.step(task.context, begin);
  const TimeNs used = hooks_.now() - begin;
  ++counters.runs;
  if (used > static_cast<TimeNs>(task.budget_us) * 1000) ++counters.overruns;
  counters.busy_total += used;
  counters.busy_max.raise_to(used);
  return step;
}

void Scheduler::forget_idle(int core) {
  for (size_t i = 0; i < count_; ++i) {
    if (runs_on(tasks_[i], core)) states_[i].idle = false;
  }
}

void Scheduler::forget_asked(int core) {
  for (size_t i = 0; i < count_; ++i) {
    if (runs_on(tasks_[i], core)) states_[i].asked = INT64_MAX;
  }
}

}  // namespace pirvs
