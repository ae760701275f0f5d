// What    Where the camera-to-IMU adjustment starts: the rotation between camera and IMU, the time
//         offset, the direction of gravity; and whether the samples are what they should be.
// In      The board's pose in the left camera over time; IMU samples.
// Out     R_BC, offset, g_T (unit vector), gyro bias.
// Frames  T: the board; B: the IMU; C: the left camera.
// Units   s: t_imu = t_camera + offset.
// Errors  InputError by name: too little turning, clocks apart by more than kOffset_s_max, gyro in
//         degrees, accelerometer in g, a board of another size, samples that have nothing to do with
//         the images.
// Cost    ~0.2 s for 70 s.
// Source  turn rates of both: Wahba's problem for each offset, the best offset by its residual.
#pragma once

#include <vector>

#include "bsp/api/imu.h"
#include "tools/calib/camera_adjustment.h"

namespace pirvs::tools {

inline constexpr double kOffset_s_max = 0.3;

struct MotionStart {
  Mat3 R_BC = Mat3::Identity();
  double offset_s = 0;
  Vec3 gravity_T = Vec3::UnitZ();
  Vec3 b_g = Vec3::Zero();
};

MotionStart start_motion(const std::vector<PosedShot>& shots, const std::vector<ImuSample>& imu);

}  // namespace pirvs::tools
