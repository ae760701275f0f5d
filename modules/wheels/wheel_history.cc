#include "modules/wheels/wheel_history.h"

namespace pirvs {

// From the newest back: that is where it is looked for.
size_t WheelHistory::first_after(TimeNs t) const {
  size_t i = end_;
  while (i > begin() && (*this)[i - 1].sample_t > t) --i;
  return i;
}

WheelPath integrate(const ImuHistory& imu, const WheelHistory& wheels, TimeNs t0, TimeNs t1,
                    const Vec3& b_g, const ImuNoise& noise, WheelPath path) {
  Preintegration motion;
  motion.reset(b_g, Vec3::Zero());
  size_t next = wheels.first_after(t0);
  if (next > wheels.begin()) path.speed(wheels[next - 1].velocity, wheels[next - 1].slips);
  for (size_t i = imu.first_at(t0) + 1; i < imu.end() && imu[i].t <= t1; ++i) {
    const ImuSample &before = imu[i - 1], &now = imu[i];
    const Mat3 dR_before = motion.dR;
    const double dt_s = to_seconds(now.t - before.t);
    motion.add(before.w_B, before.f_B, now.w_B, now.f_B, dt_s, noise);
    path.turn(dR_before, motion, dt_s);
    for (; next < wheels.end() && wheels[next].sample_t <= now.t; ++next) {
      path.speed(wheels[next].velocity, wheels[next].slips);
    }
  }
  path.end();
  return path;
}

}  // namespace pirvs
