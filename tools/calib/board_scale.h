// What    How large the board is against what its yaml says, by what the accelerometer feels.
// In      The board's poses in the left camera; samples; R_BC, time offset and gyro bias.
// Out     metres over metres of the yaml: 0.9 where the board is smaller than it says; its sigma.
// Frames  T, B, C as imu_camera.h.
// Errors  false: the motion says nothing of it (sigma above kScaleSigma_max).
// Cost    ~20 ms a minute.
// Source  second differences of places against the samples between them: p(t + h) - 2 p(t) +
//         p(t - h) is the acceleration weighted by a triangle. Linear in scale, lever arm, gravity
//         and bias.
#pragma once

#include <vector>

#include "tools/calib/motion_start.h"

namespace pirvs::tools {

inline constexpr double kScaleSigma_max = 0.02;

bool board_scale(const std::vector<PosedShot>& shots, const std::vector<ImuSample>& imu,
                 const MotionStart& start, double& scale, double& sigma);

}  // namespace pirvs::tools
