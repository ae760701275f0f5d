// How much noisier than its data sheet the IMU is taken to be. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"
#include "modules/imu/imu_noise.h"

namespace pirvs {

struct ImuParams {
  float gyro_noise_scale = 2.0f;
  float accel_noise_scale = 12.0f;
};

inline constexpr ParamRow<ImuParams> kImuRows[] = {
    {"gyro_noise_scale", &ImuParams::gyro_noise_scale, 0.1f, 50, "1", Audience::kUser,
     "factor on the calibrated white noise of the gyro, for vibration, scale and alignment errors"},
    {"accel_noise_scale", &ImuParams::accel_noise_scale, 0.1f, 50, "1", Audience::kUser,
     "factor on the calibrated white noise of the accelerometer, for vibration, scale and "
     "alignment errors"},
};
static_assert(sizeof(ImuParams) == std::size(kImuRows) * sizeof(float));
static_assert(in_range(ImuParams{}, kImuRows));

// The walks stay as calibrated.
inline ImuNoise scaled(const ImuNoise& noise, const ImuParams& params) {
  ImuNoise out = noise;
  out.gyro_noise *= params.gyro_noise_scale;
  out.accel_noise *= params.accel_noise_scale;
  return out;
}

}  // namespace pirvs
