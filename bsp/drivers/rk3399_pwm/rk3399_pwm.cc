#include "bsp/drivers/rk3399_pwm/rk3399_pwm.h"

#include "bsp/api/clock.h"
#include "bsp/drivers/rk3399_pwm/rk3399_pwm_registers.h"

namespace pirvs::bsp {

using namespace rk3399_pwm;

namespace {

constexpr int kTries = 3;

uint64_t to_ticks(uint32_t t_ns, uint32_t clock_hz) {
  return (uint64_t{t_ns} * clock_hz + 500'000'000) / 1'000'000'000;
}

}  // namespace

Result<TriggerStart> Rk3399Pwm::start(const TriggerTiming& timing) const {
  const uint64_t period = to_ticks(timing.period_ns, clock_hz_);
  const uint64_t width = to_ticks(timing.width_ns, clock_hz_);
  if (width == 0 || width >= period || timing.phase_ns >= timing.period_ns) {
    return Status::kBadData;
  }
  const double tick_ns = 1e9 / clock_hz_;
  const uint32_t polarity = timing.active_low ? kCtrlInactivePositive : kCtrlDutyPositive;
  registers_.write(kCTRL, polarity);
  registers_.write(kPERIOD_HPR, static_cast<uint32_t>(period));
  registers_.write(kDUTY_LPR, static_cast<uint32_t>(width));
  for (int i = 0; i < kTries; ++i) {
    const TimeNs last = now() - timing.phase_ns;
    const TimeNs target = last - last % timing.period_ns + timing.period_ns + timing.phase_ns;
    TimeNs before = now();
    while (before < target) before = now();
    registers_.write(kCTRL, polarity | kCtrlEnable | kCtrlContinuous);
    const uint32_t count = registers_.read(kCNT);
    const TimeNs after = now();
    if (after - target <= kTriggerError) {
      const TimeNs since = static_cast<TimeNs>(count * tick_ns + 0.5);
      return TriggerStart{before + (after - before) / 2 - since,
                          static_cast<double>(period) * tick_ns};
    }
    registers_.write(kCTRL, polarity);
  }
  return Status::kTimeout;
}

void Rk3399Pwm::stop() const { registers_.change(kCTRL, kCtrlEnable, 0); }

}  // namespace pirvs::bsp
