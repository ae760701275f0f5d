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
    hooks_.wait(core, next_period(core));
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

void Scheduler::stop() {
  stopped_.store(true, std::memory_order_relaxed);
  for (size_t i = 0; i < count_; ++i) hooks_.wake(tasks_[i].core);
}

void Scheduler::trigger(size_t task) {
  PIRVS_ASSERT(task < count_ && tasks_[task].triggered);
  State& state = states_[task];
  // Release: what the caller wrote before is visible to the step.
  if (state.pending.exchange(true, std::memory_order_acq_rel)) ++state.counters.slips;
  hooks_.wake(tasks_[task].core);
}

bool Scheduler::run_first_due(int core, Mode mode) {
  const TimeNs now = hooks_.now();
  for (size_t i = 0; i < count_; ++i) {
    if (!runs_on(tasks_[i], core) || !is_due(i, now, mode)) continue;
    const Step step = execute(i, now);
    if (step == Step::kAgain) forget_idle(core);
    if (step == Step::kAgain && mode == Mode::kTimed) wake_others(i);
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

// Release, in the hook: what the step wrote is visible to the steps that it leaves work for.
void Scheduler::wake_others(size_t i) {
  for (size_t other = 0; other < count_; ++other) {
    const bool has_work = (tasks_[i].wakes >> other & 1) != 0;
    if (has_work && tasks_[other].core != tasks_[i].core) hooks_.wake(tasks_[other].core);
  }
}

TimeNs Scheduler::next_period(int core) const {
  TimeNs next = hooks_.now() + kRest_ns;
  for (size_t i = 0; i < count_; ++i) {
    const bool periodic = tasks_[i].period_us > 0 && !tasks_[i].triggered;
    if (periodic && runs_on(tasks_[i], core)) next = std::min(next, states_[i].due);
  }
  return next;
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
