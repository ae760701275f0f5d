// Tuning of mapping. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct MappingParams {
  float window = 10.0f;
  float extend_map = 1.0f;
  float fixed_keyframes = 12.0f;
  float fixed_weight = 0.3f;
  float shared_points_min = 12.0f;
  float iterations_max = 5.0f;
  float sigma_px = 0.6f;
  float robust_sigma = 2.3f;
  float outlier_sigma = 3.0f;
  float parallax_rad_min = 0.02f;
  float stereo_parallax_rad_min = 0.004f;
  float new_point_residual_px = 2.0f;
  float point_sigma_rel_max = 0.25f;
  float start_sigma_accel_bias = 0.2f;
  float start_sigma_gyro_bias = 0.02f;
  float prior_vision_weight = 0.5f;
  float anchor_sigma_rad = 0.01f;
  float anchor_sigma_m = 0.05f;
};

inline constexpr ParamRow<MappingParams> kMappingRows[] = {
    {"window", &MappingParams::window, 3, 12, count_of("keyframes"), Audience::kUser,
     "free keyframes of a bundle adjustment; fewer cost less time and accuracy"},
    {"extend_map", &MappingParams::extend_map, 0, 1, "1", Audience::kUser,
     "0: a map that is loaded stays as it is, what is new is not saved; 1: it grows"},
    {"fixed_keyframes", &MappingParams::fixed_keyframes, 0, 24, count_of("keyframes"),
     Audience::kExpert, "older, covisible keyframes whose poses a bundle adjustment keeps fixed"},
    {"fixed_weight", &MappingParams::fixed_weight, 0, 1, "1", Audience::kExpert,
     "weight of the observations by fixed keyframes, since their poses have errors of their own"},
    {"shared_points_min", &MappingParams::shared_points_min, 1, 200, count_of("points"),
     Audience::kExpert,
     "map points that a fixed keyframe must share with the window to be covisible"},
    {"iterations_max", &MappingParams::iterations_max, 1, 30, count_of("steps"), Audience::kExpert,
     "Levenberg-Marquardt steps of a bundle adjustment"},
    {"sigma_px", &MappingParams::sigma_px, 0.05f, 10, "px", Audience::kExpert,
     "standard deviation of an observation in the image"},
    {"robust_sigma", &MappingParams::robust_sigma, 0.5f, 1e6f, "sigma", Audience::kExpert,
     "residual that weighs a quarter of what it would as a square; its weight vanishes further "
     "off"},
    {"outlier_sigma", &MappingParams::outlier_sigma, 1, 20, "sigma", Audience::kExpert,
     "residual from which an observation is removed as an outlier after the adjustment"},
    {"parallax_rad_min", &MappingParams::parallax_rad_min, 0.001f, 0.5f, "rad", Audience::kExpert,
     "smallest parallax of a point triangulated from one moving camera"},
    {"stereo_parallax_rad_min", &MappingParams::stereo_parallax_rad_min, 0.001f, 0.5f, "rad",
     Audience::kExpert, "smallest parallax of a point triangulated from a stereo pair"},
    {"new_point_residual_px", &MappingParams::new_point_residual_px, 0.1f, 20, "px",
     Audience::kExpert, "largest reprojection error of a newly triangulated point"},
    {"point_sigma_rel_max", &MappingParams::point_sigma_rel_max, 0.01f, 10, "1", Audience::kExpert,
     "largest standard deviation, as a share of its distance, of a point that tracking may use"},
    {"start_sigma_accel_bias", &MappingParams::start_sigma_accel_bias, 0.001f, 2, "m/s^2",
     Audience::kExpert, "prior standard deviation of the accelerometer bias at a start"},
    {"start_sigma_gyro_bias", &MappingParams::start_sigma_gyro_bias, 1e-4f, 0.5f, "rad/s",
     Audience::kExpert, "standard deviation of the gyro bias that a start has estimated"},
    {"prior_vision_weight", &MappingParams::prior_vision_weight, 0.01f, 1, "1", Audience::kExpert,
     "weight of vision's information about a keyframe that leaves the window, in the prior of the "
     "next: the rest of the window is not exact either"},
    {"anchor_sigma_rad", &MappingParams::anchor_sigma_rad, 1e-5f, 1, "rad", Audience::kExpert,
     "standard deviation of the prior on the gauge's heading, at the window's oldest keyframe"},
    {"anchor_sigma_m", &MappingParams::anchor_sigma_m, 1e-5f, 10, "m", Audience::kExpert,
     "standard deviation of the prior on the gauge's position, at the window's oldest keyframe"},
};
static_assert(sizeof(MappingParams) == std::size(kMappingRows) * sizeof(float));
static_assert(in_range(MappingParams{}, kMappingRows));

}  // namespace pirvs
