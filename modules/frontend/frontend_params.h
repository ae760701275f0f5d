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
  float lk_return_px_max = 0.8f;
  float bin_wait_frames = 3.0f;
};

inline constexpr ParamRow<FrontendParams> kFrontendRows[] = {
    {"tracks_target", &FrontendParams::tracks_target, 10, 240, "1", "tracks wanted per camera"},
    {"bin_px", &FrontendParams::bin_px, kBinMin_px, kBinMax_px, "px",
     "side of a spatial bin, one new corner each"},
    {"track_spacing_px_min", &FrontendParams::track_spacing_px_min, 4, 64, "px",
     "no new corner nearer to a track"},
    {"corner_response_min", &FrontendParams::corner_response_min, 0, 1e9f, "grey^2",
     "weakest Shi-Tomasi response that becomes a track"},
    {"lk_levels", &FrontendParams::lk_levels, 2, 5, "1", "pyramid levels that flow is followed on"},
    {"lk_iterations_max", &FrontendParams::lk_iterations_max, 1, 30, "1",
     "Gauss-Newton steps per level"},
    {"lk_step_px_min", &FrontendParams::lk_step_px_min, 0.001f, 1, "px",
     "flow has converged below this step"},
    {"lk_residual_grey_max", &FrontendParams::lk_residual_grey_max, 1, 128, "grey",
     "drop a track above this mean |dI|"},
    {"lk_return_px_max", &FrontendParams::lk_return_px_max, 0.05f, 10, "px",
     "drop a track that flows back to another place"},
    {"bin_wait_frames", &FrontendParams::bin_wait_frames, 0, 30, "frames",
     "pause of a bin in which no corner was found"},
};
static_assert(sizeof(FrontendParams) == std::size(kFrontendRows) * sizeof(float));

}  // namespace pirvs
