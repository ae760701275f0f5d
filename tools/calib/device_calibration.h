// What    A device's whole calibration from one recording, and whether it is good enough to ship.
// In      Shots of the board, IMU samples; what was dropped on the way; limits.
// Out     Cameras, camera to IMU; each limit with what was measured; warnings.
// Units   as cameras.h, imu_camera.h.
// Errors  InputError by name, what to do: as cameras.h and imu_camera.h; two boards in view,
//         blurred images, a recording full of holes.
// Cost    a minute of two cores for a minute of recording.
// Source  PIRVS paper, section II.
#pragma once

#include <string>
#include <vector>

#include "tools/calib/cameras.h"
#include "tools/calib/imu_camera.h"
#include "tools/dataset/input_log.h"

namespace pirvs::tools {

inline constexpr double kRecording_s_max = 180;  // more says nothing new and takes long

struct DeviceLimits {
  double within_px = 0.2, across_px = 0.3;      // a tag, on shots left out
  double focal_percent = 0.1, centre_px = 0.3;  // one sigma of each; so below
  double rotation_deg = 0.03, place_mm = 1, baseline_mm = 0.1, offset_ms = 0.05;
  double gyro_scale_percent = 0.1, accel_scale_percent = 0.2;
  double gyro_excess = 3, accel_excess = 4;  // noise over its densities
};

struct DeviceRecording {
  Target target;
  std::vector<Shot> shots;
  int cameras = 2;
  CameraOptions how;
  std::vector<ImuSample> imu;
  ImuCameraOptions motion;
  size_t tags_twice = 0;  // dropped, since the image has them twice
  double left_out_s = 0;  // of images that were not looked at, after kRecording_s_max
};

struct DeviceCheck {
  std::string what, unit;
  double value = 0, limit = 0;
  bool passed() const { return value <= limit; }  // false for NaN
};

struct DeviceResult {
  CameraResult cameras;
  ImuCameraResult imu;
  std::vector<DeviceCheck> checks;
  std::vector<std::string> warnings;
  bool passed() const;
};

// Cuts what is too long, refuses what has holes or shows two boards; returns warnings.
std::vector<std::string> tidy(DeviceRecording& recording);

DeviceResult calibrate_device(DeviceRecording recording, const DeviceLimits& limits);

}  // namespace pirvs::tools
