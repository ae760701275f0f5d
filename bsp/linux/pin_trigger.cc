#include "bsp/linux/pin_trigger.h"

#include <algorithm>

#include "bsp/api/clock.h"

namespace pirvs::bsp {

PulsePlan centred(const PulsePlan& plan, TimeNs t,
                  const TimeNs (&exposure_ns)[PinTrigger::kAhead]) {
  PulsePlan out = plan;
  const TimeNs period = plan.period_ns, since = t - plan.first_t;
  // Rounded down also where the frame is older than the first point.
  const TimeNs half = since + period / 2;
  const TimeNs k = half >= 0 ? half / period : -((-half + period - 1) / period);
  out.first_t += k * period;
  out.lead_ns[0] = exposure_ns[0] / 2;
  for (int i = 0; i < PinTrigger::kAhead; ++i) out.lead_ns[1 + i] = exposure_ns[i] / 2;
  return out;
}

void PinTrigger::configure(const char* pin, bool urgent) {
  name_ = pin;
  urgent_ = urgent;
}

Status PinTrigger::fail(Status status, const char* why) {
  why_ = why;
  return status;
}

Result<TriggerStart> PinTrigger::start(const TriggerTiming& timing) {
  const bool possible = timing.width_ns > 0 && timing.width_ns <= timing.period_ns / 2 &&
                        timing.phase_ns < timing.period_ns && !timing.active_low;
  if (!possible) return fail(Status::kBadData, "a pulse is at most half a period long, and high");
  (void)stop();
  const char* const why = pin_.open(name_, false, "pirvsd");
  if (why != nullptr) return fail(Status::kBusFault, why);
  const TimeNs period = timing.period_ns;
  plan_ = PulsePlan{};
  plan_.period_ns = period;
  // Not the next one, for which the thread may come too late.
  plan_.first_t = ((now() - timing.phase_ns) / period + 2) * period + timing.phase_ns;
  plan_.until_t = INT64_MAX;
  plan_.counted = true;
  thread_.plan(plan_);
  if (thread_.start(pin_, timing.width_ns, urgent_) != Status::kOk) {
    (void)stop();
    return fail(Status::kBusFault, "no thread for the trigger's pulses");
  }
  return TriggerStart{plan_.first_t, static_cast<double>(period), PulseThread::kSpin_ns};
}

void PinTrigger::centre(TimeNs t, const TimeNs (&exposure_ns)[kAhead]) {
  if (!runs()) return;
  // A frame that claims to be of the future must not stop the pulses until then.
  plan_ = centred(plan_, std::min(t, now()), exposure_ns);
  thread_.plan(plan_);
}

Status PinTrigger::stop() {
  thread_.stop();
  pin_.close();
  plan_ = PulsePlan{};
  return Status::kOk;
}

}  // namespace pirvs::bsp
