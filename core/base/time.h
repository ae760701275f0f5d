// Absolute time and the way to intervals in seconds.
// In      Nanoseconds on the one clock that also stamps every sensor, or seconds.
// Out     The other one; from_seconds rounds to the nearest nanosecond, halves away from zero.
// Errors  from_seconds needs |s| < 9.2e9 (292 years); to_seconds is exact to one part in 2^53.
// Cost    One conversion and one division or multiplication.
// Source  DESIGN, "Frames, units, names".
#pragma once

#include <cstdint>

namespace pirvs {

using TimeNs = int64_t;

constexpr double to_seconds(TimeNs dt) { return static_cast<double>(dt) / 1e9; }

constexpr TimeNs from_seconds(double s) {
  return static_cast<TimeNs>(s * 1e9 + (s < 0.0 ? -0.5 : 0.5));
}

}  // namespace pirvs
