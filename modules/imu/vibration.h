// Measures how much an IMU is shaken faster than a body moves, as dead reckoning feels it.
// In      samples in order of time.
// Out     noise densities that hold what motors add to the sensor's own.
// Units   as ImuNoise.
// Errors  none: before kBlocks of samples it says nothing.
// Cost    ~10 ns a sample, x86-64.
// Source  own. Means over blocks of 20 ms keep of a tone what an integral keeps of it; the second
//         difference of three of them takes the motion out, and of white noise leaves 3/2.
#pragma once

#include "bsp/api/imu.h"
#include "modules/imu/imu_noise.h"

namespace pirvs {

class VibrationMeter {
 public:
  void reset() { *this = VibrationMeter{}; }
  void add(const ImuSample& sample);
  // `noise` and what exceeds the usual: of a flight, imu.*_noise_scale holds it.
  ImuNoise on_top_of(const ImuNoise& noise) const;
  double gyro_density() const;   // of each axis, rad/s/sqrt(Hz)
  double accel_density() const;  // m/s^2/sqrt(Hz)

 private:
  struct Block {
    Vec3 w_B = Vec3::Zero(), f_B = Vec3::Zero();
  };
  void close(double duration_s);

  Block sum_, last_, before_last_;
  int samples_ = 0, blocks_ = 0;
  TimeNs begin_ = 0;
  double gyro2_ = 0, accel2_ = 0;  // squared densities
};

}  // namespace pirvs
