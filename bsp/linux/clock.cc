#include "bsp/api/clock.h"

#include <errno.h>
#include <time.h>

#include "bsp/linux/clock.h"

namespace pirvs::bsp {
namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;

TimeNs read_clock(clockid_t id) {
  timespec time;
  clock_gettime(id, &time);
  return static_cast<TimeNs>(time.tv_sec) * kSecond_ns + time.tv_nsec;
}

}  // namespace

TimeNs now() { return read_clock(CLOCK_MONOTONIC); }

void sleep_until(TimeNs t) {
  const timespec until = {static_cast<time_t>(t / kSecond_ns), static_cast<long>(t % kSecond_ns)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) continue;
}

TimeNs cpu_time() { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace pirvs::bsp
