// What the wheels of a vehicle tell, as it comes.
// Units   ns on the IMU's clock; values as WheelKind says. Forward and to the left are positive.
#pragma once

#include <cstdint>

#include "core/base/time.h"

namespace pirvs {

enum class WheelKind : uint8_t {
  kLeftRight,  // speed of the left and of the right wheel, m/s
  kTwist,      // speed, m/s, and turn rate, rad/s
  kTicks,      // counters of the left and of the right encoder
  kSteering,   // speed of the axle that does not steer, m/s, and the steering angle, rad
};
inline constexpr int kWheelKinds = 4;

struct WheelSample {
  TimeNs t = 0;
  double value[2] = {0, 0};
  WheelKind kind = WheelKind::kLeftRight;
};

}  // namespace pirvs
