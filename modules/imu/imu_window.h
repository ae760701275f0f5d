// The last IMU samples, and the motion that they say lies between two of their times.
// In      samples in order. Out: Preintegration from t0 to t1 at given biases.
// Errors  samples missing at either end shorten the motion: compare dt_s.
// Cost    ~0.35 us a sample between the two times, x86-64.
// Source  modules/imu/preintegration.h.
#pragma once

#include "core/base/time.h"
#include "core/store/fixed_vector.h"
#include "modules/imu/imu_sample.h"
#include "modules/imu/preintegration.h"

namespace pirvs {

using ImuWindow = FixedVector<ImuSample, 2048>;

Preintegration integrate(const ImuWindow& imu, TimeNs t0, TimeNs t1, const Vec3& b_g,
                         const Vec3& b_a, const ImuNoise& noise);

}  // namespace pirvs
