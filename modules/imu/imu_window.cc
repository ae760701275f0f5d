#include "modules/imu/imu_window.h"

namespace pirvs {

Preintegration integrate(const ImuWindow& imu, TimeNs t0, TimeNs t1, const Vec3& b_g,
                         const Vec3& b_a, const ImuNoise& noise) {
  Preintegration sum;
  sum.reset(b_g, b_a);
  for (size_t i = 1; i < imu.size(); ++i) {
    const ImuSample &a = imu[i - 1], &b = imu[i];
    if (a.t < t0 || b.t > t1) continue;
    sum.add(a.w_B, a.f_B, b.w_B, b.f_B, to_seconds(b.t - a.t),
            bridged(noise, static_cast<double>(b.gap_s)));
  }
  return sum;
}

}  // namespace pirvs
