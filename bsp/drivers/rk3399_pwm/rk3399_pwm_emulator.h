// An emulated PWM channel of the RK3399 for tests of its driver.
// In      The driver's accesses; the rate of the channel's clock.
// Out     output(t): the level of the pin at time t of now(). enabled_t(): when it was switched on.
// Errors  See emulated/register_file.h.
// Source  rk3399_pwm_registers.h.
#pragma once

#include <cstdint>

#include "bsp/drivers/emulated/register_file.h"
#include "bsp/drivers/rk3399_pwm/rk3399_pwm_registers.h"
#include "core/base/time.h"

namespace pirvs::bsp::emulated {

class Rk3399PwmChip {
 public:
  static constexpr uint32_t kSize = 0x10;

  explicit Rk3399PwmChip(uint32_t clock_hz) : clock_hz_(clock_hz) {}

  uint32_t read(uint32_t offset);
  void write(uint32_t offset, uint32_t value);
  bool output(TimeNs t) const;
  bool enabled() const { return (file_.peek(rk3399_pwm::kCTRL) & rk3399_pwm::kCtrlEnable) != 0; }
  TimeNs enabled_t() const { return enabled_t_; }

 private:
  uint32_t count(TimeNs t) const;

  RegisterFile file_{rk3399_pwm::kRegisters};
  uint32_t clock_hz_;
  TimeNs enabled_t_ = 0;
};

}  // namespace pirvs::bsp::emulated
