// Tuning of mapping. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct MappingParams {
  float window = 10.0f;
  float fixed_keyframes = 12.0f;
  float fixed_weight = 0.1f;
  float shared_points_min = 12.0f;
  float iterations_max = 5.0f;
  float sigma_px = 0.6f;
  float huber_sigma = 1.5f;
  float outlier_sigma = 3.0f;
  float parallax_rad_min = 0.02f;
  float stereo_parallax_rad_min = 0.004f;
  float new_point_residual_px = 2.0f;
  float point_sigma_rel_max = 0.25f;
  float start_sigma_accel_bias = 0.2f;
  float start_sigma_gyro_bias = 0.02f;
  float prior_sigma_rad = 0.002f;
  float prior_sigma_m = 0.005f;
  float anchor_sigma_rad = 0.01f;
  float anchor_sigma_m = 0.05f;
};

inline constexpr ParamRow<MappingParams> kMappingRows[] = {
    {"window", &MappingParams::window, 3, 12, "1", "keyframes that an adjustment moves"},
    {"fixed_keyframes", &MappingParams::fixed_keyframes, 0, 24, "1",
     "older keyframes that hold an adjustment in place"},
    {"fixed_weight", &MappingParams::fixed_weight, 0, 1, "1",
     "weight of an observation by an older keyframe, whose pose is not exact either"},
    {"shared_points_min", &MappingParams::shared_points_min, 1, 200, "1",
     "points that an older keyframe must share with the window"},
    {"iterations_max", &MappingParams::iterations_max, 1, 30, "1", "Levenberg-Marquardt steps"},
    {"sigma_px", &MappingParams::sigma_px, 0.05f, 10, "px", "noise of an observation"},
    {"huber_sigma", &MappingParams::huber_sigma, 0.5f, 10, "sigma",
     "where the robust cost becomes linear"},
    {"outlier_sigma", &MappingParams::outlier_sigma, 1, 20, "sigma",
     "observations worse than this leave the map"},
    {"parallax_rad_min", &MappingParams::parallax_rad_min, 0.001f, 0.5f, "rad",
     "smallest angle between rays of a point triangulated over time"},
    {"stereo_parallax_rad_min", &MappingParams::stereo_parallax_rad_min, 0.001f, 0.5f, "rad",
     "smallest angle between rays of a stereo point"},
    {"new_point_residual_px", &MappingParams::new_point_residual_px, 0.1f, 20, "px",
     "largest residual of a new point"},
    {"point_sigma_rel_max", &MappingParams::point_sigma_rel_max, 0.01f, 10, "1",
     "points less certain than this share of their distance are not given to tracking"},
    {"start_sigma_accel_bias", &MappingParams::start_sigma_accel_bias, 0.001f, 2, "m/s^2",
     "accelerometer bias expected at a start"},
    {"start_sigma_gyro_bias", &MappingParams::start_sigma_gyro_bias, 1e-4f, 0.5f, "rad/s",
     "uncertainty of the gyro bias found by a start"},
    {"prior_sigma_rad", &MappingParams::prior_sigma_rad, 1e-5f, 0.1f, "rad",
     "vision's relative attitude of two keyframes, in the prior at the window's end"},
    {"prior_sigma_m", &MappingParams::prior_sigma_m, 1e-5f, 1, "m",
     "vision's relative position of two keyframes, in the prior at the window's end"},
    {"anchor_sigma_rad", &MappingParams::anchor_sigma_rad, 1e-5f, 1, "rad",
     "hold on the heading of the window's oldest keyframe"},
    {"anchor_sigma_m", &MappingParams::anchor_sigma_m, 1e-5f, 10, "m",
     "hold on the place of the window's oldest keyframe"},
};
static_assert(sizeof(MappingParams) == std::size(kMappingRows) * sizeof(float));

}  // namespace pirvs
