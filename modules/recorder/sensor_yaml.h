// The sensor.yaml of a camera or an IMU, as an ASL folder has it.
// In      a text with room for 2 kB.
// Out     the whole file; numbers with all their digits, so that they are read as they were.
// Units   as the format has them: m, s, rad/s/sqrt(Hz), m/s^2/sqrt(Hz).
// Errors  none: the text is full() when it was too short.
// Source  docs/formats.md; EuRoC's recordings.
#pragma once

#include "core/base/text.h"
#include "core/base/time.h"
#include "core/camera/camera.h"
#include "modules/imu/imu_intrinsics.h"
#include "modules/imu/imu_noise.h"

namespace pirvs {

// `offset` as in calibration.h: the stamp on the IMU's clock is that of the camera and `offset`.
void put_camera_yaml(TextWriter& text, const Camera& camera, TimeNs offset);
void put_intrinsics(TextWriter& text, const ImuIntrinsics& intrinsics);  // nothing: not given
void put_imu_yaml(TextWriter& text, const ImuNoise& noise, const ImuIntrinsics& intrinsics);

}  // namespace pirvs
