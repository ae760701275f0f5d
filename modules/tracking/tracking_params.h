// Tuning of tracking. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct FilterParams {
  float sigma_px = 0.6f;
  float chi2_max = 9.21f;
  float robust_sigma = 2.0f;
  float iterations_max = 3.0f;
  float point_cov_scale = 1.0f;
  float standstill_sigma_m_s = 0.005f;
  float standstill_sigma_rad_s = 0.002f;
  float standstill_sigma_m_s2 = 0.05f;
  float standstill_shift_m = 0.0005f;
  float standstill_turn_rad = 1e-4f;
  float standstill_px_scale = 8.0f;
};

inline constexpr ParamRow<FilterParams> kFilterRows[] = {
    {"sigma_px", &FilterParams::sigma_px, 0.05f, 10, "px", Audience::kExpert,
     "standard deviation of a track's place in the image"},
    {"chi2_max", &FilterParams::chi2_max, 1, 100, "1", Audience::kExpert,
     "chi-squared gate of a correspondence (2 degrees of freedom; 9.21: 99 %)"},
    {"robust_sigma", &FilterParams::robust_sigma, 0.5f, 1e6f, "sigma", Audience::kExpert,
     "residual that weighs half of what it would as a square (Cauchy's weight)"},
    {"iterations_max", &FilterParams::iterations_max, 1, 10, count_of("steps"), Audience::kExpert,
     "iterations of the filter's update"},
    {"point_cov_scale", &FilterParams::point_cov_scale, 0, 100, "1", Audience::kExpert,
     "factor on the covariance of the map points"},
    {"standstill_sigma_m_s", &FilterParams::standstill_sigma_m_s, 1e-4f, 1, "m/s",
     Audience::kExpert, "standard deviation of the zero-velocity measurement at standstill"},
    {"standstill_sigma_rad_s", &FilterParams::standstill_sigma_rad_s, 1e-5f, 1, "rad/s",
     Audience::kExpert, "standard deviation of the zero-rate measurement at standstill"},
    {"standstill_sigma_m_s2", &FilterParams::standstill_sigma_m_s2, 1e-4f, 1, "m/s^2",
     Audience::kExpert,
     "standard deviation of the measurement that gravity is the only specific force at standstill"},
    {"standstill_shift_m", &FilterParams::standstill_shift_m, 1e-6f, 0.1f, "m/sqrt(s)",
     Audience::kExpert, "random walk of the position that remains possible at standstill"},
    {"standstill_turn_rad", &FilterParams::standstill_turn_rad, 1e-7f, 0.1f, "rad/sqrt(s)",
     Audience::kExpert, "random walk of the attitude that remains possible at standstill"},
    {"standstill_px_scale", &FilterParams::standstill_px_scale, 1, 100, "1", Audience::kExpert,
     "factor on sigma_px at standstill, where the errors of successive frames are correlated"},
};
static_assert(sizeof(FilterParams) == std::size(kFilterRows) * sizeof(float));
static_assert(in_range(FilterParams{}, kFilterRows));

struct TrackerParams {
  float keyframe_distance_m = 0.4f;
  float keyframe_angle_deg = 12.0f;
  float keyframe_matched_ratio_min = 0.6f;
  float keyframe_interval_s_min = 0.12f;
  float keyframe_interval_s_max = 1.0f;
  float misses_max = 3.0f;
  float start_s = 0.7f;
  float start_keyframe_s = 0.14f;
  float start_scale_sigma_max = 0.1f;
  float start_mono_after_s = 0.5f;
  float recognise_every_s = 0.2f;
  float recognise_wait_s = 0.5f;
  float loop_every_s = 0.5f;
  float loop_matches_min = 30.0f;
  float loop_held_max = 1.5f;
  float cov_scale = 1.0f;
  float estimate_time = 0.0f;
};

inline constexpr ParamRow<TrackerParams> kTrackerRows[] = {
    {"keyframe_distance_m", &TrackerParams::keyframe_distance_m, 0.01f, 10, "m", Audience::kUser,
     "distance from the last keyframe that makes a new one: about a tenth of the scene's distance"},
    {"keyframe_angle_deg", &TrackerParams::keyframe_angle_deg, 1, 90, "deg", Audience::kUser,
     "rotation since the last keyframe that makes a new one: about a sixth of the field of view"},
    {"keyframe_matched_ratio_min", &TrackerParams::keyframe_matched_ratio_min, 0, 1, "1",
     Audience::kExpert, "share of tracks with a map point below which a new keyframe is made"},
    {"keyframe_interval_s_min", &TrackerParams::keyframe_interval_s_min, 0, 5, "s",
     Audience::kExpert, "shortest time between keyframes"},
    {"keyframe_interval_s_max", &TrackerParams::keyframe_interval_s_max, 0.1f, 60, "s",
     Audience::kExpert, "longest time between keyframes in motion"},
    {"misses_max", &TrackerParams::misses_max, 0, 50, count_of("frames"), Audience::kExpert,
     "a track rejected by the gate in more frames in a row is dropped"},
    {"start_s", &TrackerParams::start_s, 0.2f, 2, "s", Audience::kExpert,
     "length of the sequence that a start is computed from"},
    {"start_keyframe_s", &TrackerParams::start_keyframe_s, 0.05f, 0.5f, "s", Audience::kExpert,
     "interval between the keyframes of a start"},
    {"start_scale_sigma_max", &TrackerParams::start_scale_sigma_max, 0.005f, 1, "1",
     Audience::kExpert,
     "largest relative standard deviation of the scale that a start from one camera accepts"},
    {"start_mono_after_s", &TrackerParams::start_mono_after_s, 0, 60, "s", Audience::kExpert,
     "time for which a start waits for the second camera before it uses one camera alone"},
    {"recognise_every_s", &TrackerParams::recognise_every_s, 0, 60, "s", Audience::kExpert,
     "interval between attempts to relocalize while the place is unknown"},
    {"recognise_wait_s", &TrackerParams::recognise_wait_s, 0, 60, "s", Audience::kExpert,
     "time after images return for which keyframes wait for a relocalization"},
    {"loop_every_s", &TrackerParams::loop_every_s, 0, 60, "s", Audience::kExpert,
     "interval between attempts to detect a loop"},
    {"loop_matches_min", &TrackerParams::loop_matches_min, 4, 400, count_of("matches"),
     Audience::kExpert, "inliers among old points, of one pose, that close a loop"},
    {"loop_held_max", &TrackerParams::loop_held_max, 0, 100, "1", Audience::kExpert,
     "a loop is not closed when more old points than this multiple of its inliers are tracked "
     "already: they constrain the pose"},
    {"cov_scale", &TrackerParams::cov_scale, 0.1f, 100, "1", Audience::kExpert,
     "factor on the output covariance: the errors of one point's observations are correlated, "
     "which no noise model here accounts for"},
    {"estimate_time", &TrackerParams::estimate_time, 0, 1, "1", Audience::kUser,
     "1: the time offset between cameras and IMU is estimated and corrected while tracking; 0: "
     "what "
     "the calibration says holds, and an offset that is seen is told"},
};
static_assert(sizeof(TrackerParams) == std::size(kTrackerRows) * sizeof(float));
static_assert(in_range(TrackerParams{}, kTrackerRows));

}  // namespace pirvs
