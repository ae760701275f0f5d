// The IMU sample of the bsp contract, for modules that only compute with it.
#pragma once

#include "bsp/api/imu.h"

namespace pirvs {

// On the line from a to b, at a time t between theirs.
inline ImuSample interpolated(const ImuSample& a, const ImuSample& b, TimeNs t) {
  const double s = to_seconds(t - a.t) / to_seconds(b.t - a.t);
  ImuSample out;
  out.t = t;
  out.w_B = a.w_B + s * (b.w_B - a.w_B);
  out.f_B = a.f_B + s * (b.f_B - a.f_B);
  out.gap_s = b.gap_s;
  return out;
}

// While stamps may be wrong: the sample with the noise of interpolation over a gap of 0.2 s.
inline ImuSample doubted(const ImuSample& sample) {
  constexpr float kDoubt_s = 0.2f;
  ImuSample out = sample;
  if (out.gap_s < kDoubt_s) out.gap_s = kDoubt_s;
  return out;
}

}  // namespace pirvs
