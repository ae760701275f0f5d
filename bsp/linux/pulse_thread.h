// Pulses on a pin at given times, by a thread that is more urgent than the stack's.
// In      start(): a pin that is open, the width of a pulse. plan(): from one core; the newest plan
//         counts: points at first_t, and every period_ns until `until_t`; a pulse begins as long
//         before its point as the plan says.
// Out     The pin, high for each pulse.
// Units   ns on CLOCK_MONOTONIC.
// Errors  start: kBusFault: no thread. A pulse that could not begin within kLate_ns of its time,
//         nor before its point, is left out and counted; likewise, of a plan that counts them,
//         points that passed while this thread did not run. late(): pulses more than kSpin_ns late.
// Cost    Sleeps until kSpin_ns before a pulse, then waits by looking at the clock: 0.6 % of a core
//         at 60 Hz.
// Source  The kernel's threads for interrupts run at priority 50: a thread that spins above them
//         would make them lose edges, so this one stays below.
#pragma once

#include <pthread.h>

#include <atomic>

#include "bsp/linux/pins.h"
#include "core/store/mailbox.h"

namespace pirvs::bsp {

struct PulsePlan {
  static constexpr int kLeads = 10;

  TimeNs first_t = 0, period_ns = 0, until_t = 0;
  TimeNs lead_ns[kLeads] = {};  // of the first points; the last one is that of all others, too
  bool counted = false;         // no point may be passed over without a count

  TimeNs begin_of(TimeNs point) const {
    const TimeNs k = (point - first_t) / period_ns;
    return point - lead_ns[k < kLeads ? k : kLeads - 1];
  }
};

// The first point of a plan that is not before t; INT64_MAX: there is none.
inline TimeNs next_pulse(const PulsePlan& plan, TimeNs t) {
  if (plan.period_ns <= 0) return INT64_MAX;
  const TimeNs behind = t - plan.first_t;
  const TimeNs k = behind <= 0 ? 0 : (behind + plan.period_ns - 1) / plan.period_ns;
  const TimeNs next = plan.first_t + k * plan.period_ns;
  return next <= plan.until_t ? next : INT64_MAX;
}

class PulseThread {
 public:
  static constexpr TimeNs kLate_ns = 1'000'000;
  static constexpr TimeNs kSpin_ns = 100'000;
  static constexpr int kPriority = 45;

  ~PulseThread() { stop(); }

  Status start(OutputPin& pin, TimeNs width_ns, bool urgent);
  void plan(const PulsePlan& plan) {
    plans_.back() = plan;
    plans_.publish();
  }
  void stop();

  uint32_t pulses() const { return pulses_; }
  uint32_t late() const { return late_; }
  uint32_t left_out() const { return left_out_; }

 private:
  void run();
  void take_plan();
  void count_passed_over(TimeNs point);
  void pulse(TimeNs point);

  OutputPin* pin_ = nullptr;
  TimeNs width_ns_ = 0;
  pthread_t thread_{};
  bool runs_ = false;
  std::atomic<bool> stop_{false};
  Mailbox<PulsePlan> plans_;
  PulsePlan plan_;
  TimeNs last_t_ = INT64_MIN;  // the last point
  Counter pulses_, late_, left_out_;
};

}  // namespace pirvs::bsp
