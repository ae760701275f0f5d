// Tuning of tracking. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct FilterParams {
  float sigma_px = 1.0f;
  float chi2_max = 9.21f;
  float huber_sigma = 2.0f;
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
    {"sigma_px", &FilterParams::sigma_px, 0.05f, 10, "px", "noise of a tracked point"},
    {"chi2_max", &FilterParams::chi2_max, 1, 100, "1",
     "gate of a correspondence (2 dof; 9.21: 99 %)"},
    {"huber_sigma", &FilterParams::huber_sigma, 0.5f, 10, "sigma",
     "where the robust weight begins"},
    {"iterations_max", &FilterParams::iterations_max, 1, 10, "1", "iterations of the update"},
    {"point_cov_scale", &FilterParams::point_cov_scale, 0, 100, "1",
     "times the map points' own covariance"},
    {"standstill_sigma_m_s", &FilterParams::standstill_sigma_m_s, 1e-4f, 1, "m/s",
     "noise of zero velocity"},
    {"standstill_sigma_rad_s", &FilterParams::standstill_sigma_rad_s, 1e-5f, 1, "rad/s",
     "noise of zero rate"},
    {"standstill_sigma_m_s2", &FilterParams::standstill_sigma_m_s2, 1e-4f, 1, "m/s^2",
     "noise of gravity as the only force"},
    {"standstill_shift_m", &FilterParams::standstill_shift_m, 1e-6f, 0.1f, "m/sqrt(s)",
     "what rest leaves open of the place"},
    {"standstill_turn_rad", &FilterParams::standstill_turn_rad, 1e-7f, 0.1f, "rad/sqrt(s)",
     "what rest leaves open of the attitude"},
    {"standstill_px_scale", &FilterParams::standstill_px_scale, 1, 100, "1",
     "at rest, times the noise of a tracked point: each frame says the same again"},
};
static_assert(sizeof(FilterParams) == std::size(kFilterRows) * sizeof(float));

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
  float cov_scale = 1.8f;
};

inline constexpr ParamRow<TrackerParams> kTrackerRows[] = {
    {"keyframe_distance_m", &TrackerParams::keyframe_distance_m, 0.01f, 10, "m",
     "new keyframe when this far from the last"},
    {"keyframe_angle_deg", &TrackerParams::keyframe_angle_deg, 1, 90, "deg",
     "new keyframe when turned this far from the last"},
    {"keyframe_matched_ratio_min", &TrackerParams::keyframe_matched_ratio_min, 0, 1, "1",
     "new keyframe when fewer tracks than this share have a map point"},
    {"keyframe_interval_s_min", &TrackerParams::keyframe_interval_s_min, 0, 5, "s",
     "shortest time between keyframes"},
    {"keyframe_interval_s_max", &TrackerParams::keyframe_interval_s_max, 0.1f, 60, "s",
     "longest time between keyframes while moving"},
    {"misses_max", &TrackerParams::misses_max, 0, 50, "frames",
     "a track gated out more often in a row is dropped"},
    {"start_s", &TrackerParams::start_s, 0.2f, 2, "s", "time that a start looks at"},
    {"start_keyframe_s", &TrackerParams::start_keyframe_s, 0.05f, 0.5f, "s",
     "spacing of the first keyframes"},
    {"start_scale_sigma_max", &TrackerParams::start_scale_sigma_max, 0.005f, 1, "1",
     "a start from one camera waits until its scale is this certain"},
    {"start_mono_after_s", &TrackerParams::start_mono_after_s, 0, 60, "s",
     "a start waits this long for the second camera of a pair"},
    {"recognise_every_s", &TrackerParams::recognise_every_s, 0, 60, "s",
     "time between looks for an old place while the place is unknown"},
    {"recognise_wait_s", &TrackerParams::recognise_wait_s, 0, 60, "s",
     "after blindness, mapping waits this long for the place to be recognised"},
    {"loop_every_s", &TrackerParams::loop_every_s, 0, 60, "s", "time between looks for a loop"},
    {"loop_matches_min", &TrackerParams::loop_matches_min, 4, 400, "1",
     "matches with old points that fit one pose and close a loop"},
    {"loop_held_max", &TrackerParams::loop_held_max, 0, 100, "1",
     "times as many points tracked that are as old: the old place holds the pose already"},
    {"cov_scale", &TrackerParams::cov_scale, 0.1f, 100, "1",
     "times the covariance on its way out: views of one point share errors that no model knows"},
};
static_assert(sizeof(TrackerParams) == std::size(kTrackerRows) * sizeof(float));

}  // namespace pirvs
