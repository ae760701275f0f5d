// What    What an IMU would have measured along a path.
// In      Path, noise densities (continuous time), sigma of the constant biases, seed.
// Out     Samples at rate_hz from t = 0 to the path's end, and the biases that were added.
// Frames  w_B, f_B in B; f_B = R_WB' (a_WB + g up).
// Units   rad/s, m/s^2; stamps ns from begin.
// Errors  none.
// Cost    ~0.5 us a sample.
// Source  noise: Kalibr wiki, "IMU noise model": white sigma = n sqrt(rate), walk step = w /
//         sqrt(rate).
#pragma once

#include <vector>

#include "bsp/api/imu.h"
#include "modules/imu/imu_noise.h"
#include "tools/sim/path.h"

namespace pirvs::tools {

struct ImuModel {
  ImuNoise noise;
  double gyro_bias_rad_s = 0.02;  // sigma of the bias at the start, per axis
  double accel_bias_m_s2 = 0.05;
};

struct SimulatedImu {
  ImuSample sample;
  PathState truth;
  Vec3 b_g;
  Vec3 b_a;
};

std::vector<SimulatedImu> simulate_imu(const Path& path, const ImuModel& model, TimeNs begin,
                                       uint64_t seed);

}  // namespace pirvs::tools
