// Driver of one PWM channel of the RK3399 as a camera trigger. Its pin and clock must be on
// (bsp/drivers/rk3399_setup).
// In      The channel's base address and the rate of its clock.
// Out     bsp/api/trigger.h for this output. The start is found from the counter: the pulse began
//         CNT ticks before the counter was read, whatever the write took to arrive.
// Errors  As bsp/api/trigger.h.
// Cost    As bsp/api/trigger.h. The rate of a period of 16.7 ms is exact to 0.6 ppm (half a tick of
//         20.7 ns); period_ns says what it is.
// Source  rk3399_pwm_registers.h. Clock and now() come from the same crystal.
#pragma once

#include <cstdint>

#include "bsp/api/trigger.h"
#include "bsp/drivers/register.h"

namespace pirvs::bsp {

class Rk3399Pwm {
 public:
  constexpr Rk3399Pwm(uintptr_t base, uint32_t clock_hz) : registers_(base), clock_hz_(clock_hz) {}

  Result<TriggerStart> start(const TriggerTiming& timing) const;
  void stop() const;

 private:
  Registers registers_;
  uint32_t clock_hz_;
};

}  // namespace pirvs::bsp
