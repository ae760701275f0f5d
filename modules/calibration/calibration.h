// What    a device's calibration says, as every part of the stack uses it.
// Frames  B = the IMU; each Camera carries T_BC. camera[0] is the left, camera[1] the right one.
// Units   camera_time_offset_ns: t_imu_clock = t_camera_stamp + offset, ns (Kalibr's
//         timeshift_cam_imu). GnssAntenna: t_imu_clock = stamp of a fix + offset.
// Source  PIRVS paper, section II (factory calibration).
#pragma once

#include "core/base/time.h"
#include "core/camera/camera.h"
#include "modules/imu/imu_intrinsics.h"
#include "modules/imu/imu_noise.h"
#include "modules/wheels/wheel_calibration.h"

namespace pirvs {

struct GnssAntenna {
  Vec3 p_BA = Vec3::Zero();  // of its phase centre in B
  TimeNs time_offset_ns = 0;
};

struct Calibration {
  Camera camera[2];
  int cameras = 2;
  ImuNoise imu;
  ImuIntrinsics imu_intrinsics;
  TimeNs camera_time_offset_ns = 0;
  GnssAntenna gnss;
  WheelCalibration wheels;
};

}  // namespace pirvs
