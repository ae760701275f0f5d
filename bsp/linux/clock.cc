#include "bsp/api/clock.h"

#include <time.h>

namespace pirvs::bsp {
namespace {

TimeNs read_clock(clockid_t id) {
  timespec time;
  clock_gettime(id, &time);
  return static_cast<TimeNs>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

TimeNs now() { return read_clock(CLOCK_MONOTONIC); }

TimeNs cpu_time() { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace pirvs::bsp
