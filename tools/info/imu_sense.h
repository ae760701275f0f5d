// What    Whether an IMU's samples can be what a calibrated IMU on a moving body senses.
// In      Samples in order of time, a second of them or more.
// Out     What is wrong, and what to do: g instead of m/s^2, no gravity, deg/s instead of rad/s,
//         columns exchanged, rows of one sensor without the other. An empty `what`: nothing.
// Units   m/s^2, rad/s, as the stack takes them.
// Errors  none of its own.
// Cost    a sort, ~10 ms for a minute.
// Source  Gravity's size; in a body that turns, the specific force turns the other way: df/dt is
//         about -w x f where the body itself accelerates little (docs/formats.md).
#pragma once

#include <string>
#include <vector>

#include "bsp/api/imu.h"

namespace pirvs::tools {

struct ImuFault {
  std::string what, what_to_do;
};

ImuFault find_imu_fault(const std::vector<ImuSample>& samples);

}  // namespace pirvs::tools
