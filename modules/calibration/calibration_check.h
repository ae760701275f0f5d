// Does a calibration make sense? Asked once, before anything is built on it.
// In      A Calibration as read.
// Out     nullptr: it does. Otherwise what is wrong and what to do, in one line each.
// Frames  as in calibration.h.
// Errors  none of its own.
// Cost    microseconds, at start.
// Source  What has been seen in calibration files: inverted transforms, swapped cameras, mm for m,
//         another resolution's intrinsics, variances for densities.
#pragma once

#include "modules/calibration/calibration.h"

namespace pirvs {

struct CalibrationFault {
  const char* where = "";  // "cam0", "cam1", "imu", "cameras", "gnss"
  const char* what = nullptr;
  const char* what_to_do = "";

  explicit operator bool() const { return what != nullptr; }
};

// What a number of the IMU may be.
struct ImuBand {
  double ImuNoise::*field;
  double min, max;
  const char* what;  // is wrong where it is not
  const char* unit;
  const char* what_to_do;
};
inline constexpr const char* kDensities = "give densities in SI units per sqrt(Hz), not variances";
inline constexpr ImuBand kImuBands[] = {
    {&ImuNoise::gyro_noise, 1e-6, 0.1, "the gyro's noise density is not within 1e-6 to 0.1",
     "rad/s/sqrt(Hz)", kDensities},
    {&ImuNoise::gyro_walk, 1e-9, 0.1, "the gyro's random walk is not within 1e-9 to 0.1",
     "rad/s^2/sqrt(Hz)", kDensities},
    {&ImuNoise::accel_noise, 1e-5, 1, "the accelerometer's noise density is not within 1e-5 to 1",
     "m/s^2/sqrt(Hz)", kDensities},
    {&ImuNoise::accel_walk, 1e-8, 1, "the accelerometer's random walk is not within 1e-8 to 1",
     "m/s^3/sqrt(Hz)", kDensities},
    {&ImuNoise::rate_hz, 20, 20'000, "the rate is not within 20 to 20000 Hz", "Hz",
     "give samples per second"},
};

CalibrationFault find_fault(const Calibration& calibration);

}  // namespace pirvs
