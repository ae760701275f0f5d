// Tuning of the image front-end. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

inline constexpr int kBinMin_px = 16, kBinMax_px = 64;  // sides that memory and corner_best() take

struct FrontendParams {
  float tracks_target = 180.0f;
  float bin_px = 36.0f;
  float track_spacing_px_min = 12.0f;
  float corner_response_min = 0.0f;
  float lk_levels = 4.0f;
  float lk_iterations_max = 8.0f;
  float lk_step_px_min = 0.03f;
  float lk_residual_grey_max = 18.0f;
  float lk_residual_ratio_max = 2.0f;
  float lk_return_px_max = 0.8f;
  float look_shift_px_max = 3.0f;
  float look_residual_ratio_max = 2.5f;
  float bin_wait_frames = 3.0f;
};

inline constexpr ParamRow<FrontendParams> kFrontendRows[] = {
    {"tracks_target", &FrontendParams::tracks_target, 10, 240, count_of("tracks"), Audience::kUser,
     "tracks per camera that detection aims at; more cost time in every frame"},
    {"bin_px", &FrontendParams::bin_px, kBinMin_px, kBinMax_px, count_of("px"), Audience::kExpert,
     "side of the grid cells of detection, one new corner in each; larger where the grid would "
     "hold too many"},
    {"track_spacing_px_min", &FrontendParams::track_spacing_px_min, 4, 64, "px", Audience::kExpert,
     "smallest distance of a new corner to the other tracks"},
    {"corner_response_min", &FrontendParams::corner_response_min, 0, 1e9f, "grey^2",
     Audience::kExpert, "smallest Shi-Tomasi response of a corner that becomes a track"},
    {"lk_levels", &FrontendParams::lk_levels, 2, 5, count_of("levels"), Audience::kExpert,
     "pyramid levels of optical flow"},
    {"lk_iterations_max", &FrontendParams::lk_iterations_max, 1, 30, count_of("steps"),
     Audience::kExpert, "Gauss-Newton steps of optical flow per pyramid level"},
    {"lk_step_px_min", &FrontendParams::lk_step_px_min, 0.001f, 1, "px", Audience::kExpert,
     "a step of optical flow below this has converged"},
    {"lk_residual_grey_max", &FrontendParams::lk_residual_grey_max, 1, 128, "grey",
     Audience::kExpert, "largest mean absolute difference between a track's patch and the image"},
    {"lk_residual_ratio_max", &FrontendParams::lk_residual_ratio_max, 1, 100, "1",
     Audience::kExpert, "that difference as a multiple of its median over the image's tracks"},
    {"lk_return_px_max", &FrontendParams::lk_return_px_max, 0.05f, 10, "px", Audience::kExpert,
     "forward-backward check: largest distance to where flow back to the previous image should "
     "end"},
    {"look_shift_px_max", &FrontendParams::look_shift_px_max, 0, 20, "px", Audience::kExpert,
     "how far from where it is expected a track is looked for by its first look alone, without the "
     "pyramid"},
    {"look_residual_ratio_max", &FrontendParams::look_residual_ratio_max, 0.5f, 100, "1",
     Audience::kExpert,
     "largest residual of a track against its first look, as a multiple of the median over the "
     "last image's tracks; above it the track is followed from image to image"},
    {"bin_wait_frames", &FrontendParams::bin_wait_frames, 0, 30, count_of("frames"),
     Audience::kExpert, "frames for which a grid cell without a corner is not searched again"},
};
static_assert(sizeof(FrontendParams) == std::size(kFrontendRows) * sizeof(float));
static_assert(in_range(FrontendParams{}, kFrontendRows));

}  // namespace pirvs
