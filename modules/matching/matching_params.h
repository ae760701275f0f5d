// Tuning of matching map points to tracks. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct MatchingParams {
  float match_distance_max = 60.0f;
  float match_ratio_max = 0.85f;
  float match_radius_px_min = 3.0f;
  float match_radius_px_max = 20.0f;
  float recognise_matches_min = 12.0f;
  float loop_keyframes_min = 30.0f;
};

inline constexpr ParamRow<MatchingParams> kMatchingRows[] = {
    {"match_distance_max", &MatchingParams::match_distance_max, 1, 256, "bit",
     "worst descriptor distance of a match by projection"},
    {"match_ratio_max", &MatchingParams::match_ratio_max, 0.1f, 1, "1",
     "best over second best descriptor distance"},
    {"match_radius_px_min", &MatchingParams::match_radius_px_min, 0.5f, 50, "px",
     "smallest search window of a projected point"},
    {"match_radius_px_max", &MatchingParams::match_radius_px_max, 1, 200, "px",
     "largest search window of a projected point"},
    {"recognise_matches_min", &MatchingParams::recognise_matches_min, 4, 200, "1",
     "matches that fit one pose and make a place recognised"},
    {"loop_keyframes_min", &MatchingParams::loop_keyframes_min, 5, 384, "1",
     "a point seen last so many keyframes ago is old: where it is found again, a loop closes"},
};
static_assert(sizeof(MatchingParams) == std::size(kMatchingRows) * sizeof(float));
static_assert(in_range(MatchingParams{}, kMatchingRows));

}  // namespace pirvs
