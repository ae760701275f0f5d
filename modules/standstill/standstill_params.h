// Limits of standstill detection. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct StandstillParams {
  float window_samples = 64.0f;
  float gyro_rad_s = 0.02f;
  float accel_m_s2 = 0.25f;
  float gravity_m_s2 = 0.5f;
  float rate_rad_s = 0.02f;
  float force_m_s2 = 0.3f;
  float patience_s = 3.0f;
  float image_px = 0.3f;
  float image_s = 0.5f;
};

inline constexpr ParamRow<StandstillParams> kStandstillRows[] = {
    {"window_samples", &StandstillParams::window_samples, 8, 256, count_of("samples"),
     Audience::kExpert, "IMU samples over which standstill is tested"},
    {"gyro_rad_s", &StandstillParams::gyro_rad_s, 1e-4f, 1, "rad/s", Audience::kUser,
     "largest standard deviation of the angular rate at standstill: noise and the vibration of "
     "idle motors"},
    {"accel_m_s2", &StandstillParams::accel_m_s2, 1e-3f, 10, "m/s^2", Audience::kUser,
     "largest standard deviation of the specific force at standstill: noise and the vibration of "
     "idle motors"},
    {"gravity_m_s2", &StandstillParams::gravity_m_s2, 0.01f, 10, "m/s^2", Audience::kExpert,
     "largest difference between the magnitudes of the mean specific force and of gravity at "
     "standstill"},
    {"rate_rad_s", &StandstillParams::rate_rad_s, 1e-3f, 1, "rad/s", Audience::kExpert,
     "largest difference between the mean rate and the estimated gyro bias when standstill begins; "
     "half of it ends standstill"},
    {"force_m_s2", &StandstillParams::force_m_s2, 0.01f, 10, "m/s^2", Audience::kExpert,
     "largest difference between the mean specific force and the one expected from the estimated "
     "attitude and bias when standstill begins; half of it ends standstill"},
    {"patience_s", &StandstillParams::patience_s, 0.1f, 60, "s", Audience::kExpert,
     "time after which standstill is accepted although rate_rad_s or force_m_s2 is exceeded: a "
     "wrong start may have caused it"},
    {"image_px", &StandstillParams::image_px, 0.05f, 10, "px", Audience::kExpert,
     "a track that leaves its place by more than this is moving"},
    {"image_s", &StandstillParams::image_s, 0.05f, 10, "s", Audience::kExpert,
     "time for which a track must stay within image_px to count as still"},
};
static_assert(sizeof(StandstillParams) == std::size(kStandstillRows) * sizeof(float));
static_assert(in_range(StandstillParams{}, kStandstillRows));

}  // namespace pirvs
