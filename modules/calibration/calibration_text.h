// A calibration as a device reads it: plain `key = value` (core/config/key_values.h), numbers that
// read back to the bit or beside it.
// In      The text of a file; or a Calibration.
// Out     The calibration. All keys of a camera and of the IMU must be there, once:
//           cameras = 2                               1: the left one alone
//           camera_time_offset_ns = 0                 as in calibration.h
//           cam0.model = radtan                       or equidistant; cam1 likewise
//           cam0.size = 752 480                       pixels
//           cam0.focal = 458.654 457.296              fx fy, pixels
//           cam0.centre = 367.215 248.375             cx cy, pixels
//           cam0.distortion = -0.283 0.074 0 0        four, as core/camera/camera.h has them
//           cam0.T_BC = ...                           twelve: the upper three rows; the rotation
//                                                     is made exact
//           imu.gyro_noise = 1.7e-4                   imu_noise.h; gyro_walk, accel_noise,
//           imu.rate_hz = 200                         accel_walk likewise
//         These may be missing; they are identity or zero then, and are not written:
//           imu.gyro_matrix = 1.01 0 0 ...            nine, by rows (imu_intrinsics.h);
//           imu.gyro_bias = 0.01 0 -0.02              accel_matrix, accel_bias likewise
//           gnss.antenna = 0 0 0.1                    metres, in B
//           gnss.time_offset_ns = 0
// Frames, units  as in calibration.h.
// Errors  A fault with its line; the calibration is then undefined. Whether it makes sense is asked
//         of find_fault (calibration_check.h).
// Cost    microseconds, at start.
// Source  `pirvs calibration` writes it from an ASL folder or from Kalibr's camchain.
#pragma once

#include <string_view>

#include "core/base/text.h"
#include "core/config/key_values.h"
#include "modules/calibration/calibration.h"

namespace pirvs {

inline constexpr size_t kCalibrationTextMax = 4096;

[[nodiscard]] ConfigFault read_calibration(std::string_view text, Calibration& out);
void write_calibration(const Calibration& calibration, TextWriter& out);

}  // namespace pirvs
