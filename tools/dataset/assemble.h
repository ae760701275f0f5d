// What    What every reader of a recording does with its parts: rig, samples, lists of images.
// In      take_rig: a Rig, with recording.imu already read; where the calibration is from, for
//         errors. add_frames: both cameras' images in order of time; what the left list is called.
//         join_sensors: a gyro's and an accelerometer's samples in order of time.
// Out     take_rig: calibration and turns; the IMU's rate, measured where no file has it.
//         add_frames: recording.frames, in pairs. join_sensors: the gyro's samples with the force
//         interpolated to their times.
// Units   ns; rad/s, m/s^2.
// Errors  InputError: a calibration that makes no sense. Gaps and lone images are counted, noted.
#pragma once

#include <string>
#include <vector>

#include "tools/dataset/pairs.h"
#include "tools/dataset/recording.h"

namespace pirvs::tools {

void take_rig(const Rig& rig, const std::string& where, Recording& recording);
void add_frames(const Rig& rig, const std::vector<ListedImage>& left,
                const std::vector<ListedImage>& right, const std::string& left_name,
                Recording& recording);
std::vector<ImuSample> join_sensors(const std::vector<ImuSample>& gyro,
                                    const std::vector<ImuSample>& accel);

}  // namespace pirvs::tools
