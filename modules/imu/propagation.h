// Moves a state and its covariance over the interval between two IMU samples: the filter's
// prediction step, and the output's.
// In      the state at the time of `a`, its covariance (error order of body_state.h), both samples.
// Out     the same at the time of `b`; the error's `transition`, if it is asked for. b.gap_s widens
//         the noise (imu_noise.h).
// Errors  none; b.t > a.t is the caller's to see to (the sensor door orders samples).
// Cost    ~3 us, x86-64.
// Source  PIRVS paper, eqs. 1 to 5; docs/conventions.md, "Propagation".
#pragma once

#include "modules/imu/imu_noise.h"
#include "modules/imu/imu_sample.h"
#include "modules/state/body_state.h"

namespace pirvs {

void propagate(const ImuSample& a, const ImuSample& b, const ImuNoise& noise, BodyState& state,
               Mat15& cov, Mat15* transition = nullptr);

}  // namespace pirvs
