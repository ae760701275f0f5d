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

CalibrationFault find_fault(const Calibration& calibration);

}  // namespace pirvs
