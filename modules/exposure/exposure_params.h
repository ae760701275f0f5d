// How long and how strongly the cameras expose. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct ExposureParams {
  float automatic = 1;
  float exposure_s = 0;
  float gain = 0;
  float mean_grey = 90;
  float blur_px = 3;
  float longest_s = 0.03f;
  float readout_s = 0.005f;
  float gain_max = 8;
  float mains_hz = 50;
  float gamma = 1;
  float band = 0.15f;
  float highlights = 2;
  float delay_frames = 3;
};

inline constexpr ParamRow<ExposureParams> kExposureRows[] = {
    {"automatic", &ExposureParams::automatic, 0, 1, count_of(""), Audience::kUser,
     "1: exposure and gain of live cameras are controlled, equal for both; 0: they are left as the "
     "cameras have them"},
    {"exposure_s", &ExposureParams::exposure_s, 0, 0.2f, "s", Audience::kUser,
     "fixed exposure time; 0: it is controlled"},
    {"gain", &ExposureParams::gain, 0, 64, "", Audience::kUser,
     "fixed gain, as a factor; 0: it is controlled"},
    {"mean_grey", &ExposureParams::mean_grey, 30, 200, "grey", Audience::kUser,
     "mean of both images that is aimed at, less where there are highlights"},
    {"blur_px", &ExposureParams::blur_px, 0.5f, 20, "px", Audience::kUser,
     "largest motion blur by the present angular rate; gain replaces exposure beyond it"},
    {"longest_s", &ExposureParams::longest_s, 1e-4f, 0.2f, "s", Audience::kUser,
     "longest exposure; the period between frames limits it as well"},
    {"readout_s", &ExposureParams::readout_s, 0, 0.05f, "s", Audience::kUser,
     "part of the period that a triggered sensor needs besides its exposure, so that it is ready "
     "for the next trigger"},
    {"gain_max", &ExposureParams::gain_max, 1, 64, "", Audience::kUser,
     "largest gain, as a factor; the cameras may have less"},
    {"mains_hz", &ExposureParams::mains_hz, 0, 60, count_of("Hz"), Audience::kUser,
     "50 or 60: frequency of the mains, whose lamps flicker at twice of it; exposures longer than "
     "a period of the flicker are whole multiples of it. 0: no flicker"},
    {"gamma", &ExposureParams::gamma, 1, 2.5f, "", Audience::kUser,
     "of the cameras' response: grey is proportional to light^(1/gamma). 1 converges for any "
     "camera; more than the camera has makes it oscillate"},
    {"band", &ExposureParams::band, 0.02f, 0.5f, "", Audience::kExpert,
     "relative error of exposure that is not corrected"},
    {"highlights", &ExposureParams::highlights, 0, 10, "", Audience::kExpert,
     "how many times a saturated pixel counts in the mean besides once"},
    {"delay_frames", &ExposureParams::delay_frames, 1, 8, count_of("frames"), Audience::kExpert,
     "images after a change that may still be of the old exposure, where the camera does not tell"},
};
static_assert(sizeof(ExposureParams) == std::size(kExposureRows) * sizeof(float));
static_assert(in_range(ExposureParams{}, kExposureRows));

}  // namespace pirvs
