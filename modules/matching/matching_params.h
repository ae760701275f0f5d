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
    {"match_distance_max", &MatchingParams::match_distance_max, 1, 256, "bit", Audience::kExpert,
     "largest Hamming distance of the descriptors of a match"},
    {"match_ratio_max", &MatchingParams::match_ratio_max, 0.1f, 1, "1", Audience::kExpert,
     "ratio test: largest quotient of the best and the second best descriptor distance"},
    {"match_radius_px_min", &MatchingParams::match_radius_px_min, 0.5f, 50, "px", Audience::kExpert,
     "smallest search radius around a projected map point"},
    {"match_radius_px_max", &MatchingParams::match_radius_px_max, 1, 200, "px", Audience::kExpert,
     "largest search radius around a projected map point"},
    {"recognise_matches_min", &MatchingParams::recognise_matches_min, 4, 200, count_of("matches"),
     Audience::kExpert, "inliers of one pose that relocalize in a known place"},
    {"loop_keyframes_min", &MatchingParams::loop_keyframes_min, 5, 384, count_of("keyframes"),
     Audience::kExpert,
     "age of a map point, in keyframes since its last observation, from which seeing it again is a "
     "loop"},
};
static_assert(sizeof(MatchingParams) == std::size(kMatchingRows) * sizeof(float));
static_assert(in_range(MatchingParams{}, kMatchingRows));

// Near enough, and nearer than the second best by the ratio test (Lowe, IJCV 2004, section 7.1).
inline bool is_match(const MatchingParams& params, int distance, int second_distance) {
  return static_cast<float>(distance) <= params.match_distance_max &&
         static_cast<float>(distance) <=
             params.match_ratio_max * static_cast<float>(second_distance);
}

}  // namespace pirvs
