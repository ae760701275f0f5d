#include "bsp/drivers/rk3399_pwm/rk3399_pwm_emulator.h"

#include "bsp/api/clock.h"

namespace pirvs::bsp::emulated {

using namespace rk3399_pwm;

uint32_t Rk3399PwmChip::count(TimeNs t) const {
  const double ticks = static_cast<double>(t - enabled_t_) * clock_hz_ / 1e9;
  return static_cast<uint32_t>(static_cast<uint64_t>(ticks) % file_.peek(kPERIOD_HPR));
}

bool Rk3399PwmChip::output(TimeNs t) const {
  const uint32_t control = file_.peek(kCTRL);
  if (!enabled()) return (control & kCtrlInactivePositive) != 0;
  const bool duty_level = (control & kCtrlDutyPositive) != 0;
  return count(t) < file_.peek(kDUTY_LPR) ? duty_level : !duty_level;
}

uint32_t Rk3399PwmChip::read(uint32_t offset) {
  file_.poke(kCNT, enabled() ? count(now()) : 0);
  return file_.load(offset);
}

void Rk3399PwmChip::write(uint32_t offset, uint32_t value) {
  const bool was_enabled = enabled();
  file_.store(offset, value);
  if (enabled() && !was_enabled) enabled_t_ = now();
}

}  // namespace pirvs::bsp::emulated
