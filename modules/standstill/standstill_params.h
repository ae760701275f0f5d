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
    {"window_samples", &StandstillParams::window_samples, 8, 256, "samples",
     "IMU samples that a standstill is judged on"},
    {"gyro_rad_s", &StandstillParams::gyro_rad_s, 1e-4f, 1, "rad/s",
     "largest spread of the rate at rest"},
    {"accel_m_s2", &StandstillParams::accel_m_s2, 1e-3f, 10, "m/s^2",
     "largest spread of the force at rest"},
    {"gravity_m_s2", &StandstillParams::gravity_m_s2, 0.01f, 10, "m/s^2",
     "largest difference of the mean force's size from gravity at rest"},
    {"rate_rad_s", &StandstillParams::rate_rad_s, 1e-3f, 1, "rad/s",
     "largest difference of the mean rate from the bias as rest begins; half of it ends rest"},
    {"force_m_s2", &StandstillParams::force_m_s2, 0.01f, 10, "m/s^2",
     "largest difference of the mean force from what the pose says as rest begins; half ends rest"},
    {"patience_s", &StandstillParams::patience_s, 0.1f, 60, "s",
     "rest is believed against both after this long: a bad start may have got them wrong"},
    {"image_px", &StandstillParams::image_px, 0.05f, 10, "px",
     "a track that goes further than this from its place moves"},
    {"image_s", &StandstillParams::image_s, 0.05f, 10, "s",
     "a track stands once it has not done so for this long"},
};
static_assert(sizeof(StandstillParams) == std::size(kStandstillRows) * sizeof(float));
static_assert(in_range(StandstillParams{}, kStandstillRows));

}  // namespace pirvs
