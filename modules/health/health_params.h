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
};

inline constexpr ParamRow<HealthParams> kHealthRows[] = {
    {"matches_min", &HealthParams::matches_min, 1, 100, "1",
     "fewer accepted correspondences: degraded"},
    {"lost_s", &HealthParams::lost_s, 0.1f, 60, "s", "degraded for longer and uncertain: lost"},
    {"lost_sigma_m", &HealthParams::lost_sigma_m, 0.01f, 100, "m",
     "position sigma above which a degraded track is lost"},
    {"recover_matches", &HealthParams::recover_matches, 1, 200, "1",
     "so many accepted correspondences end a degraded state"},
    {"recover_s", &HealthParams::recover_s, 0, 5, "s", "when they have been there for this long"},
    {"full_matches", &HealthParams::full_matches, 1, 400, "1",
     "accepted correspondences that deserve full confidence"},
    {"blind_half_s", &HealthParams::blind_half_s, 0.01f, 60, "s",
     "without correspondences, confidence halves over this time"},
    {"sigma_half_m", &HealthParams::sigma_half_m, 0.001f, 100, "m",
     "position sigma that halves the confidence"},
    {"jump_m", &HealthParams::jump_m, 0.001f, 10, "m", "a correction larger than this is a jump"},
    {"jump_rad", &HealthParams::jump_rad, 1e-4f, 3, "rad", "or one that turns by more than this"},
};
static_assert(sizeof(HealthParams) == std::size(kHealthRows) * sizeof(float));

}  // namespace pirvs
