// How far wheels are believed. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct WheelParams {
  float use = 1.0f;
  float sigma_m_s = 0.01f;
  float sigma_share = 0.02f;
  float scale_sigma = 0.01f;
  float side_m_s = 0.02f;
  float side_share = 0.03f;
  float turn_rad_s = 0.02f;
  float turn_share = 0.05f;
  float correlated_s = 0.2f;
  float chi2_max = 16.0f;
  float slip_hold_s = 0.3f;
  float estimate_scale = 0.0f;
};

inline constexpr ParamRow<WheelParams> kWheelRows[] = {
    {"use", &WheelParams::use, 0, 1, "1", Audience::kUser,
     "1: the speed of calibrated wheels is a measurement of tracking and mapping; 0: it is not"},
    {"sigma_m_s", &WheelParams::sigma_m_s, 1e-4f, 10, "m/s", Audience::kExpert,
     "standard deviation of the speed at standstill"},
    {"sigma_share", &WheelParams::sigma_share, 0, 1, "1", Audience::kUser,
     "standard deviation of the speed as a share of it: slip that cannot be told"},
    {"scale_sigma", &WheelParams::scale_sigma, 0, 1, "1", Audience::kUser,
     "relative standard deviation of the wheels' radius"},
    {"side_m_s", &WheelParams::side_m_s, 1e-4f, 10, "m/s", Audience::kExpert,
     "standard deviation of sideways and vertical speed at standstill"},
    {"side_share", &WheelParams::side_share, 0, 1, "1", Audience::kExpert,
     "standard deviation of sideways and vertical speed as a share of the speed"},
    {"turn_rad_s", &WheelParams::turn_rad_s, 1e-4f, 10, "rad/s", Audience::kExpert,
     "standard deviation of the turn rate at standstill"},
    {"turn_share", &WheelParams::turn_share, 0, 1, "1", Audience::kUser,
     "standard deviation of the turn rate as a share of it: large for wheels that skid in turns"},
    {"correlated_s", &WheelParams::correlated_s, 0, 60, "s", Audience::kExpert,
     "time over which the errors of samples are the same"},
    {"chi2_max", &WheelParams::chi2_max, 1, 1000, "1", Audience::kExpert,
     "chi-squared gate of a speed (3 degrees of freedom; 16.3: 99.9 %)"},
    {"slip_hold_s", &WheelParams::slip_hold_s, 0, 60, "s", Audience::kExpert,
     "time for which wheels are not used after the gate has refused them"},
    {"estimate_scale", &WheelParams::estimate_scale, 0, 1, "1", Audience::kUser,
     "1: the wheels' radius is estimated and corrected while tracking; 0: an error that is seen is "
     "told"},
};
static_assert(sizeof(WheelParams) == std::size(kWheelRows) * sizeof(float));
static_assert(in_range(WheelParams{}, kWheelRows));

}  // namespace pirvs
