#include "bsp/api/clock.h"

#include "bsp/bare/registers.h"

namespace pirvs::bsp {

TimeNs now() {
  constexpr uint64_t kSecond = 1'000'000'000;
  asm volatile("isb" ::: "memory");  // or the counter is read early
  const uint64_t ticks = PIRVS_READ(cntvct_el0);
  const uint64_t rate_hz = PIRVS_READ(cntfrq_el0);
  const uint64_t rest = ticks % rate_hz;  // below 2^32, so the product fits
  return static_cast<TimeNs>(ticks / rate_hz * kSecond + rest * kSecond / rate_hz);
}

// A core runs nothing but us.
TimeNs cpu_time() { return now(); }

}  // namespace pirvs::bsp
