// The IMU: samples in the order of their stamps.
// In      Poll until kEmpty.
// Out     The oldest sample not yet polled. t: on the clock of now(), taken in the driver.
// Frames  B: IMU body. w_B angular rate (rad/s), f_B specific force (m/s^2; +g up at rest).
//         imu_temperature: of the chip, in degrees Celsius, the newest that the driver has read.
// Errors  imu_poll: kEmpty: nothing now. kStale: the stream has ended. kFull: an overrun, samples
//         were lost before this one, which is good. kTimeout, kBusFault, kBadData: the device's
//         fault, out is undefined. imu_temperature: kNotFound: the chip does not tell it. kEmpty:
//         not yet.
// Cost    Neither ever waits. Both from one core.
// Source  docs/architecture.md: stamps are taken in the driver.
#pragma once

#include "core/base/status.h"
#include "core/base/time.h"
#include "core/math/types.h"

namespace pirvs {

struct ImuSample {
  TimeNs t = 0;
  Vec3 w_B = Vec3::Zero();
  Vec3 f_B = Vec3::Zero();
  // Length of the sequence gap before this sample, s: propagation interpolates linearly over it.
  // 0: none was lost. The door sets it; drivers leave it 0.
  float gap_s = 0;
};

namespace bsp {

Status imu_poll(ImuSample& out);
Status imu_temperature(float& degrees_C);

}  // namespace bsp
}  // namespace pirvs
