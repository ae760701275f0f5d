// The last IMU samples, by number and by time. Who delivers the samples owns one; all others read.
// In      samples in order of time.
// Out     any of them; the motion that they say lies between two of their times.
// Errors  samples missing at either end shorten the motion: ask covers(), or compare dt_s.
// Cost    131 kB; ~0.35 us a sample that is integrated, x86-64. Owner and readers share one core.
// Source  modules/imu/preintegration.h.
#pragma once

#include "core/base/assert.h"
#include "core/base/time.h"
#include "modules/imu/imu_sample.h"
#include "modules/imu/preintegration.h"

namespace pirvs {

class ImuHistory {
 public:
  static constexpr size_t kCapacity = 2048;  // 10 s at 200 Hz

  void clear() { end_ = 0; }
  void add(const ImuSample& sample) { samples_[end_++ % kCapacity] = sample; }

  // Samples are counted from clear() on; begin() to end() - 1 are still there.
  size_t begin() const { return end_ > kCapacity ? end_ - kCapacity : 0; }
  size_t end() const { return end_; }
  bool empty() const { return end_ == 0; }
  const ImuSample& operator[](size_t number) const {
    PIRVS_ASSERT(number >= begin() && number < end_);
    return samples_[number % kCapacity];
  }
  const ImuSample& newest() const { return (*this)[end_ - 1]; }

  // The first sample at t or later; end(): there is none yet.
  size_t first_at(TimeNs t) const;
  // Nothing is missing from t on.
  bool covers(TimeNs t) const { return !empty() && (*this)[begin()].t <= t; }

 private:
  ImuSample samples_[kCapacity];
  size_t end_ = 0;
};

// The motion between the samples from t0 to t1 at given biases.
Preintegration integrate(const ImuHistory& imu, TimeNs t0, TimeNs t1, const Vec3& b_g,
                         const Vec3& b_a, const ImuNoise& noise);

}  // namespace pirvs
