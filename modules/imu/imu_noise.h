// Noise densities of an IMU, as a data sheet or an Allan plot gives them (continuous time).
// Units   gyro_noise rad/s/sqrt(Hz), gyro_walk rad/s^2/sqrt(Hz), accel_noise m/s^2/sqrt(Hz),
//         accel_walk m/s^3/sqrt(Hz), rate_hz nominal samples per second.
//         bridge_rad_s, bridge_m_s2: how far the line over a long gap is from what was not
//         measured.
// Source  the model of Kalibr's imu.yaml and EuRoC's sensor.yaml.
#pragma once

#include <cmath>

namespace pirvs {

struct ImuNoise {
  double gyro_noise = 1.7e-4;
  double gyro_walk = 2.0e-5;
  double accel_noise = 2.0e-3;
  double accel_walk = 3.0e-3;
  double rate_hz = 200.0;
  double bridge_rad_s = 0.7;
  double bridge_m_s2 = 2.0;
};

// The noise of an interval within a gap that a straight line bridges (ImuSample::gap_s). The line's
// error grows with the gap's square, as that of any linear interpolation, until nothing is known
// but how hard the body moves; it is of one piece over the gap, so that its density is that times
// the root of the gap.
inline ImuNoise bridged(const ImuNoise& noise, double gap_s) {
  constexpr double kUnknown_s = 0.25;  // a hand's or a rotor craft's motion has turned by then
  if (gap_s <= 0.0) return noise;
  const double share = gap_s < kUnknown_s ? gap_s / kUnknown_s : 1.0;
  const auto add = [&](double density, double error) {
    const double line = error * share * share;
    return std::sqrt(density * density + line * line * gap_s);
  };
  ImuNoise out = noise;
  out.gyro_noise = add(noise.gyro_noise, noise.bridge_rad_s);
  out.accel_noise = add(noise.accel_noise, noise.bridge_m_s2);
  return out;
}

}  // namespace pirvs
