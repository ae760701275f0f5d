// Where the wheels are, and what one turn of theirs is.
// Frames  V: the vehicle, x forward, y left, z up; origin in the middle of the axle that does not
//         steer: the point that goes straight ahead at every moment. B: IMU.
// Units   m, ns: t_imu_clock = stamp of a sample + offset.
#pragma once

#include "core/base/time.h"
#include "core/math/se3.h"

namespace pirvs {

struct WheelCalibration {
  bool known = false;  // else what wheels tell is recorded, and not used
  SE3 T_BV;
  double track_m = 0;      // from the left to the right wheel: kLeftRight, kTicks; 0: not known
  double wheelbase_m = 0;  // from axle to axle: kSteering
  double tick_m = 0;       // way of one count: kTicks
  TimeNs time_offset_ns = 0;
};

}  // namespace pirvs
