// The mean rate of a gyro between any two times, by the integral of its samples.
// In      samples in order of time, which outlive it.
// Errors  rate: false where the samples do not reach from `begin` to `end`.
// Units   rad/s.
// Cost    O(log n) a rate.
// Source  trapezoids. The integral of the rates is no rotation: for turns that are small.
#pragma once

#include <algorithm>
#include <vector>

#include "modules/imu/imu_sample.h"

namespace pirvs::tools {

class GyroIntegral {
 public:
  explicit GyroIntegral(const std::vector<ImuSample>& samples)
      : samples_(samples), sum_(samples.size(), Vec3::Zero()) {
    for (size_t i = 1; i < samples.size(); ++i) {
      const double dt_s = to_seconds(samples[i].t - samples[i - 1].t);
      sum_[i] = sum_[i - 1] + (samples[i].w_B + samples[i - 1].w_B) * (dt_s / 2);
    }
  }
  bool rate(TimeNs begin, TimeNs end, Vec3& w_B) const {
    if (samples_.empty() || begin < samples_.front().t || end > samples_.back().t) return false;
    if (begin >= end) return false;
    w_B = (at(end) - at(begin)) / to_seconds(end - begin);
    return true;
  }

 private:
  Vec3 at(TimeNs t) const {
    const auto next = std::lower_bound(samples_.begin(), samples_.end(), t,
                                       [](const ImuSample& s, TimeNs time) { return s.t < time; });
    const size_t i = std::max<size_t>(1, size_t(next - samples_.begin()));
    const double share = double(t - samples_[i - 1].t) / double(samples_[i].t - samples_[i - 1].t);
    return sum_[i - 1] + share * (sum_[i] - sum_[i - 1]);
  }

  const std::vector<ImuSample>& samples_;
  std::vector<Vec3> sum_;
};

}  // namespace pirvs::tools
