#include "modules/imu/imu_history.h"

namespace pirvs {

size_t ImuHistory::first_at(TimeNs t) const {
  size_t low = begin(), high = end_;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if ((*this)[middle].t < t) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

Preintegration integrate(const ImuHistory& imu, TimeNs t0, TimeNs t1, const Vec3& b_g,
                         const Vec3& b_a, const ImuNoise& noise) {
  Preintegration sum;
  sum.reset(b_g, b_a);
  for (size_t i = imu.first_at(t0) + 1; i < imu.end() && imu[i].t <= t1; ++i) {
    const ImuSample &a = imu[i - 1], &b = imu[i];
    sum.add(a.w_B, a.f_B, b.w_B, b.f_B, to_seconds(b.t - a.t),
            bridged(noise, static_cast<double>(b.gap_s)));
  }
  return sum;
}

}  // namespace pirvs
