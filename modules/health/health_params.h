// Limits of health and standstill detection. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct HealthParams {
  float matches_min = 8.0f;
  float lost_s = 3.0f;
  float lost_sigma_m = 1.0f;
  float standstill_window = 64.0f;
  float standstill_gyro_rad_s = 0.02f;
  float standstill_accel_m_s2 = 0.25f;
  float standstill_image_px_s = 5.0f;
  float standstill_image_s = 0.3f;
};

inline constexpr ParamRow<HealthParams> kHealthRows[] = {
    {"matches_min", &HealthParams::matches_min, 1, 100, "1",
     "fewer accepted correspondences: degraded"},
    {"lost_s", &HealthParams::lost_s, 0.1f, 60, "s", "degraded for longer and uncertain: lost"},
    {"lost_sigma_m", &HealthParams::lost_sigma_m, 0.01f, 100, "m",
     "position sigma above which a degraded track is lost"},
    {"standstill_window", &HealthParams::standstill_window, 8, 256, "samples",
     "IMU samples that a standstill is judged on"},
    {"standstill_gyro_rad_s", &HealthParams::standstill_gyro_rad_s, 1e-4f, 1, "rad/s",
     "largest spread of the rate at rest"},
    {"standstill_accel_m_s2", &HealthParams::standstill_accel_m_s2, 1e-3f, 10, "m/s^2",
     "largest spread of the force at rest"},
    {"standstill_image_px_s", &HealthParams::standstill_image_px_s, 0.1f, 200, "px/s",
     "largest median flow at rest, over the noise of flow itself"},
    {"standstill_image_s", &HealthParams::standstill_image_s, 0.05f, 10, "s",
     "the image is still for this long before the device is at rest"},
};
static_assert(sizeof(HealthParams) == std::size(kHealthRows) * sizeof(float));

}  // namespace pirvs
