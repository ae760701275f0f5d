#include "core/sched/scheduler.h"

#include <algorithm>

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
  if (!run_first_due(core, Mode::kTimed)) {
    hooks_.relax();
    forget_idle(core);  // another core may have left something
  }
  return true;
}

void Scheduler::run_until_idle() {
  forget_idle(kAllCores);
  while (poll_lockstep()) {
  }
}

bool Scheduler::poll_lockstep() {
  if (!stopped() && run_first_due(kAllCores, Mode::kLockstep)) return true;
  say_alive(nullptr);
  forget_idle(kAllCores);
  return false;
}

void Scheduler::trigger(size_t task) {
  PIRVS_ASSERT(task < count_ && tasks_[task].triggered);
  State& state = states_[task];
  // Release: what the caller wrote before is visible to the step.
  if (state.pending.exchange(true, std::memory_order_acq_rel)) ++state.counters.slips;
}

bool Scheduler::run_first_due(int core, Mode mode) {
  const TimeNs now = hooks_.now();
  for (size_t i = 0; i < count_; ++i) {
    if (!runs_on(tasks_[i], core) || !is_due(i, now, mode)) continue;
    const Step step = execute(i, now);
    if (step == Step::kAgain) forget_idle(core);
    states_[i].again = step == Step::kAgain;
    states_[i].idle = step == Step::kIdle;
    return true;
  }
  return false;
}

// Takes the trigger or the period if there is one.
bool Scheduler::is_due(size_t i, TimeNs now, Mode mode) {
  const Task& task = tasks_[i];
  State& state = states_[i];
  if (state.again) return true;
  if (task.triggered) return state.pending.exchange(false, std::memory_order_acq_rel);
  if (mode == Mode::kTimed && task.period_us > 0) return period_has_come(i, now);
  return !state.idle;
}

bool Scheduler::period_has_come(size_t i, TimeNs now) {
  State& state = states_[i];
  const TimeNs period = static_cast<TimeNs>(tasks_[i].period_us) * 1000;
  if (!state.started) {
    state.started = true;
    state.due = now;
  }
  if (now < state.due) return false;
  const TimeNs missed = (now - state.due) / period;
  state.counters.slips += static_cast<uint32_t>(missed);
  state.due += (missed + 1) * period;
  return true;
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

}  // namespace pirvs
