#include "bsp/linux/pulse_thread.h"

#include <sched.h>

#include <algorithm>

#include "bsp/api/clock.h"
#include "bsp/linux/clock.h"

namespace pirvs::bsp {
namespace {

constexpr TimeNs kRest_ns = 20'000'000;   // between looks for a plan
constexpr TimeNs kSettle_ns = 1'500'000;  // before a pulse: the newest plan is taken once more

}  // namespace

Status PulseThread::start(OutputPin& pin, TimeNs width_ns, bool urgent) {
  stop();
  pin_ = &pin;
  width_ns_ = width_ns;
  stop_ = false;
  const auto entry = [](void* self) -> void* {
    static_cast<PulseThread*>(self)->run();
    return nullptr;
  };
  if (pthread_create(&thread_, nullptr, entry, this) != 0) return Status::kBusFault;
  runs_ = true;
  const sched_param param{kPriority};
  if (urgent) (void)pthread_setschedparam(thread_, SCHED_FIFO, &param);
  return Status::kOk;
}

void PulseThread::stop() {
  if (!runs_) return;
  stop_ = true;
  pthread_join(thread_, nullptr);
  runs_ = false;
}

bool PulseThread::take_plan() {
  const PulsePlan* const newest = plans_.take();
  if (newest != nullptr) plan_ = *newest;
  return newest != nullptr;
}

void PulseThread::pulse(TimeNs t) {
  sleep_until(t - kSpin_ns);
  while (now() < t) continue;
  last_t_ = t;
  if (now() - t > kLate_ns) {
    ++left_out_;
    return;
  }
  const TimeNs rise = now();  // later than t, if this thread was interrupted in between
  (void)pin_->write(true);
  sleep_until(rise + width_ns_);
  (void)pin_->write(false);
  ++pulses_;
}

void PulseThread::run() {
  while (!stop_) {
    take_plan();
    const TimeNs t = now();
    // Half a period from the last one: a plan that moved a little must not pulse twice.
    const TimeNs from =
        std::max(t + kSpin_ns, last_t_ == INT64_MIN ? t : last_t_ + plan_.period_ns / 2);
    const TimeNs next = next_pulse(plan_, from);
    if (next > t + kRest_ns) {
      sleep_until(t + kRest_ns);
      continue;
    }
    if (next > t + kSettle_ns) sleep_until(next - kSettle_ns);
    if (!take_plan()) {
      pulse(next);
      continue;
    }
    const TimeNs moved = next_pulse(plan_, std::max(from, next - plan_.period_ns / 2));
    if (moved < next + plan_.period_ns / 2) pulse(moved);
  }
}

}  // namespace pirvs::bsp
