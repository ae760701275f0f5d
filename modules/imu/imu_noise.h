// Noise densities of an IMU, as a data sheet or an Allan plot gives them (continuous time).
// Units   gyro_noise rad/s/sqrt(Hz), gyro_walk rad/s^2/sqrt(Hz), accel_noise m/s^2/sqrt(Hz),
//         accel_walk m/s^3/sqrt(Hz), rate_hz nominal samples per second.
// Source  the model of Kalibr's imu.yaml and EuRoC's sensor.yaml.
#pragma once

namespace pirvs {

struct ImuNoise {
  double gyro_noise = 1.7e-4;
  double gyro_walk = 2.0e-5;
  double accel_noise = 2.0e-3;
  double accel_walk = 3.0e-3;
  double rate_hz = 200.0;
};

}  // namespace pirvs
