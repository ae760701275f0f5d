// Limits of health. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct HealthParams {
  float matches_min = 8.0f;
  float lost_s = 3.0f;
  float lost_sigma_m = 1.0f;
  float recover_matches = 12.0f;
  float recover_s = 0.1f;
  float full_matches = 40.0f;
  float blind_half_s = 0.5f;
  float sigma_half_m = 0.25f;
  float jump_m = 0.05f;
  float jump_rad = 0.02f;
  float jumps_max = 1.5f;
  float rejected_share_max = 0.35f;
  float accel_bias_max_m_s2 = 2.0f;
  float gyro_bias_max_rad_s = 0.5f;
  float speed_max_m_s = 50.0f;
};

inline constexpr ParamRow<HealthParams> kHealthRows[] = {
    {"matches_min", &HealthParams::matches_min, 1, 100, count_of("matches"), Audience::kExpert,
     "a frame with fewer accepted correspondences is degraded"},
    {"lost_s", &HealthParams::lost_s, 0.1f, 60, "s", Audience::kUser,
     "tracking is lost once it has been degraded for this long and is as uncertain as "
     "lost_sigma_m"},
    {"lost_sigma_m", &HealthParams::lost_sigma_m, 0.01f, 100, "m", Audience::kUser,
     "standard deviation of the position from which degraded tracking can be lost"},
    {"recover_matches", &HealthParams::recover_matches, 1, 200, count_of("matches"),
     Audience::kExpert, "accepted correspondences that end the degraded state"},
    {"recover_s", &HealthParams::recover_s, 0, 5, "s", Audience::kExpert,
     "time for which recover_matches must hold to end the degraded state"},
    {"full_matches", &HealthParams::full_matches, 1, 400, count_of("matches"), Audience::kExpert,
     "accepted correspondences from which on they no longer reduce the confidence"},
    {"blind_half_s", &HealthParams::blind_half_s, 0.01f, 60, "s", Audience::kExpert,
     "half-life of the confidence without correspondences (dead reckoning)"},
    {"sigma_half_m", &HealthParams::sigma_half_m, 0.001f, 100, "m", Audience::kUser,
     "standard deviation of the position that halves the confidence"},
    {"jump_m", &HealthParams::jump_m, 0.001f, 10, "m", Audience::kUser,
     "a correction that moves the pose by more is reported as a jump"},
    {"jump_rad", &HealthParams::jump_rad, 1e-4f, 3, "rad", Audience::kUser,
     "a correction that turns the pose by more is reported as a jump"},
    {"jumps_max", &HealthParams::jumps_max, 0.5f, 100, "1", Audience::kExpert,
     "jumps of its own within about ten seconds from which the pose is doubted; with six times as "
     "many it is lost"},
    {"rejected_share_max", &HealthParams::rejected_share_max, 0.05f, 1, "1", Audience::kExpert,
     "share of rejected correspondences from which the pose is doubted; half way to 1 from there "
     "it is lost"},
    {"accel_bias_max_m_s2", &HealthParams::accel_bias_max_m_s2, 0.01f, 20, "m/s^2", Audience::kUser,
     "bias that the accelerometer may have; with a larger one the pose is doubted, with three "
     "times as much lost"},
    {"gyro_bias_max_rad_s", &HealthParams::gyro_bias_max_rad_s, 0.001f, 10, "rad/s",
     Audience::kUser,
     "bias that the gyro may have; with a larger one the pose is doubted, with three times as "
     "much lost"},
    {"speed_max_m_s", &HealthParams::speed_max_m_s, 0.1f, 1000, "m/s", Audience::kUser,
     "speed that the device can have; with a larger one the pose is doubted, then lost"},
};
static_assert(sizeof(HealthParams) == std::size(kHealthRows) * sizeof(float));
static_assert(in_range(HealthParams{}, kHealthRows));

}  // namespace pirvs
