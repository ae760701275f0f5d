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

void PulseThread::take_plan() {
  const PulsePlan* const newest = plans_.take();
  if (newest != nullptr) plan_ = *newest;
}

void PulseThread::count_passed_over(TimeNs point) {
  if (!plan_.counted || last_t_ == INT64_MIN) return;
  const TimeNs periods = (point - last_t_ + plan_.period_ns / 2) / plan_.period_ns;
  if (periods > 1) left_out_ += static_cast<uint32_t>(periods - 1);
}

void PulseThread::pulse(TimeNs point) {
  const TimeNs begin = plan_.begin_of(point);
  count_passed_over(point);
  last_t_ = point;
  sleep_until(begin - kSpin_ns);
  while (now() < begin) continue;
  const TimeNs rise = now();  // later than `begin`, if this thread was interrupted in between
  if (rise > std::max(begin + kLate_ns, point)) {
    ++left_out_;
    return;
  }
  if (rise - begin > kSpin_ns) ++late_;
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
    const TimeNs point = next_pulse(plan_, from);
    const TimeNs look = point == INT64_MAX ? point : plan_.begin_of(point) - kSettle_ns;
    if (look > t) {
      sleep_until(std::min(look, t + kRest_ns));
    } else {
      pulse(point);
    }
  }
}

}  // namespace pirvs::bsp
