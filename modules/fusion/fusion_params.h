// Limits and noise of fusion. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/params/params.h"

namespace pirvs {

struct FusionParams {
  float accel_m_s2 = 3.0f;
  float turn_rad = 0.1f;
  float drift_m = 0.002f;
  float drift_rad = 1e-4f;
  float slam_m = 0.003f;
  float slam_rad = 0.003f;
  float slam_m_s = 0.02f;
  float slam_chi2 = 60.0f;
  float fix_chi2 = 16.3f;
  float fix_m_min = 0.005f;
  float fix_m_max = 50.0f;
  float align_rad = 0.035f;
  float align_span_m = 4.0f;
  float align_s = 120.0f;
  float keep_rad = 0.1f;
  float doubt_s = 40.0f;
  float gnss_timeout_s = 3.0f;
  float sigma_half_m = 2.0f;
};

// Parameters are float, the filter counts in double.
inline double number(float x) { return static_cast<double>(x); }

inline constexpr ParamRow<FusionParams> kFusionRows[] = {
    {"accel_m_s2", &FusionParams::accel_m_s2, 0.01f, 100, "m/s^2/sqrt(Hz)", Audience::kUser,
     "noise of the constant velocity between two measurements: how hard the vehicle accelerates"},
    {"turn_rad", &FusionParams::turn_rad, 1e-3f, 100, "rad/sqrt(s)", Audience::kExpert,
     "random walk of the attitude between two measurements"},
    {"drift_m", &FusionParams::drift_m, 0, 1, "m/sqrt(s)", Audience::kExpert,
     "random walk of SLAM's frame beside the growth of its own covariance"},
    {"drift_rad", &FusionParams::drift_rad, 0, 0.1f, "rad/sqrt(s)", Audience::kExpert,
     "likewise of its heading"},
    {"slam_m", &FusionParams::slam_m, 1e-4f, 1, "m", Audience::kExpert,
     "noise of SLAM's position from one frame to the next"},
    {"slam_rad", &FusionParams::slam_rad, 1e-4f, 1, "rad", Audience::kExpert,
     "noise of SLAM's attitude from one frame to the next"},
    {"slam_m_s", &FusionParams::slam_m_s, 1e-3f, 10, "m/s", Audience::kExpert,
     "noise of SLAM's velocity from one frame to the next"},
    {"slam_chi2", &FusionParams::slam_chi2, 20, 1e4f, "", Audience::kExpert,
     "a pose of SLAM farther from where it is expected is a jump (chi square, 9 degrees of "
     "freedom)"},
    {"fix_chi2", &FusionParams::fix_chi2, 3, 1e3f, "", Audience::kExpert,
     "a fix farther from where it is expected is rejected (chi square, 3 degrees of freedom)"},
    {"fix_m_min", &FusionParams::fix_m_min, 1e-4f, 10, "m", Audience::kUser,
     "no fix is taken to be better than this"},
    {"fix_m_max", &FusionParams::fix_m_max, 0.1f, 1e4f, "m", Audience::kUser,
     "a fix whose receiver claims no more than this is not used"},
    {"align_rad", &FusionParams::align_rad, 1e-3f, 0.5f, "rad", Audience::kUser,
     "SLAM is aligned to the Earth once its heading is as certain as this"},
    {"align_span_m", &FusionParams::align_span_m, 0.1f, 1e3f, "m", Audience::kUser,
     "... and it has been as far apart as this"},
    {"align_s", &FusionParams::align_s, 10, 1e3f, "s", Audience::kExpert,
     "fixes that an alignment looks back on"},
    {"keep_rad", &FusionParams::keep_rad, 1e-3f, 1, "rad", Audience::kExpert,
     "with a heading less certain than this, SLAM is aligned anew when it comes back"},
    {"doubt_s", &FusionParams::doubt_s, 1, 1e3f, "s", Audience::kUser,
     "fixes that are rejected for so long, and agree with each other, are believed"},
    {"gnss_timeout_s", &FusionParams::gnss_timeout_s, 0.1f, 60, "s", Audience::kUser,
     "without an accepted fix for so long GNSS counts as out"},
    {"sigma_half_m", &FusionParams::sigma_half_m, 1e-3f, 1e3f, "m", Audience::kUser,
     "standard deviation of the position that halves the confidence"},
};
static_assert(sizeof(FusionParams) == std::size(kFusionRows) * sizeof(float));
static_assert(in_range(FusionParams{}, kFusionRows));

}  // namespace pirvs
